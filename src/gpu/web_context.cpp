// SPDX-License-Identifier: Apache-2.0
// The context of WebGL2 that the page, or its worker, has made current. There is no other.
#include "gpu/gl_context.h"

#include <emscripten/html5_webgl.h>

#include <algorithm>
#include <array>

#include "gpu/gl.h"

namespace bccsplat {
namespace {

constexpr GLenum unmasked_vendor = 0x9245, unmasked_renderer = 0x9246; // of WEBGL_debug_renderer_info

std::string gl_text(GLenum name) {
  const auto* const text = reinterpret_cast<const char*>(glGetString(name));
  return text ? text : "";
}

bool draws_on_the_cpu(const std::string& renderer) {
  constexpr std::array names{"llvmpipe", "softpipe", "SwiftShader", "Basic Render"};
  return std::any_of(names.begin(), names.end(),
                     [&](const char* n) { return renderer.find(n) != std::string::npos; });
}

} // namespace

bool any_graphics_card() { return current_gl_context() != nullptr; }

const void* current_gl_context() {
  return reinterpret_cast<const void*>(emscripten_webgl_get_current_context());
}

GpuInfo current_context_info(GpuEntry entry) {
  GpuInfo info;
  info.vendor = gl_text(unmasked_vendor), info.renderer = gl_text(unmasked_renderer);
  if (info.renderer.empty()) info.vendor = gl_text(GL_VENDOR), info.renderer = gl_text(GL_RENDERER);
  while (glGetError() != GL_NO_ERROR) { // a browser may hide what its card is
  }
  info.version = gl_text(GL_VERSION);
  info.software = draws_on_the_cpu(info.renderer);
  info.entry = GpuEntry::fragment;
  if (entry == GpuEntry::compute) fail_gpu(info.version, " has no compute shaders");
  return info;
}

GlContext::GlContext(const GpuWishes& /*wishes*/) {
  fail_gpu("a browser's context belongs to its page; make one of WebGL2 and make it current");
}

GlContext::~GlContext() = default;

} // namespace bccsplat
