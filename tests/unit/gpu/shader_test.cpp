// SPDX-License-Identifier: Apache-2.0
// The one body is GLSL ES 3.00, too, in every kind that it is compiled in.
#include "gpu/shader.h"

#include <gtest/gtest.h>

#include <string>

#include "gpu/gl.h"
#include "tests/support/gpu.h"

namespace bccsplat {
namespace {

using namespace test;

std::string for_es(std::string source) {
  const std::string desktop = "#version 330";
  return source.replace(source.find(desktop), desktop.size(), "#version 300 es");
}

TEST(Shader, IsAlsoForEs) {
  const auto gpu = test_gpu(GpuEntry::fragment);
  if (!gpu) GTEST_SKIP() << "no GPU";
  bool understood = false;
  gpu->run([&] {
    understood = epoxy_gl_version() >= 43 || epoxy_has_gl_extension("GL_ARB_ES3_compatibility");
    if (!understood) return;
    for (const RenderMode mode :
         {RenderMode::composite, RenderMode::isosurface, RenderMode::xray, RenderMode::maximum})
      for (const char* kernel : {"default", "fine", "paper"})
        for (const bool all : {false, true}) {
          ShaderKind kind;
          kind.mode = mode, kind.kernel = make_kernel(kernel).space;
          kind.normalised = make_kernel(kernel).normalised;
          kind.shading = kind.halves = kind.integrals = kind.split = all;
          kind.ripple = all && !kind.normalised;
          kind.surfaces = all ? 3 : 1;
          EXPECT_NO_THROW((void)make_program(for_es(vertex_source()), for_es(shader_source(kind))))
              << kernel << static_cast<int>(mode) << all;
        }
    EXPECT_THROW((void)make_program(for_es(vertex_source()), "#version 300 es\nvoid main() { float x = 1; }"),
                 GpuFailure);
  });
  if (!understood) GTEST_SKIP() << "a context that does not understand ES";
}

// Sites that no point of an eighth of a cell reaches are not looked at; the others all are.
TEST(Shader, BordersHoldWhatKernelsReach) {
  EXPECT_EQ(brick_border(make_kernel("fast").space), 1);
  EXPECT_EQ(brick_border(make_kernel("default").space), 1);
  EXPECT_EQ(brick_border(make_kernel("fine").space), 2);
  EXPECT_EQ(brick_border(make_kernel("gauss09").space), 2);
  ShaderKind kind;
  kind.kernel = make_kernel("default").space;
  EXPECT_NE(shader_source(kind).find("#define REACHED 20\n"), std::string::npos); // of 27
}

} // namespace
} // namespace bccsplat
