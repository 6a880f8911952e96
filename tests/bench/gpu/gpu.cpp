// SPDX-License-Identifier: Apache-2.0
// The times of a picture are those of the GPU alone (drawing, until it has finished), of a picture as a host
// gets it, and of the first one of a slice, with its bricks and their upload. Medians.
#include "tests/bench/gpu/gpu.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "draw/stage_clock.h"
#include "gpu/gpu_device.h"
#include "gpu/gpu_picture.h"
#include "gpu/value_change.h"
#include "scene/settled_picture.h"
#include "tests/bench/gpu/gpu_moments.h"
#include "tests/bench/gpu/texture_gathers.h"
#include "tests/bench/image_error.h"
#include "tests/bench/scene.h"

namespace bccsplat::bench {
namespace {

double median_ms(int rounds, const std::function<void()>& body) {
  std::vector<double> ms;
  for (int n = 0; n < rounds; ++n) {
    const auto start = std::chrono::steady_clock::now();
    body();
    ms.push_back(ms_since(start));
  }
  std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
  return ms[ms.size() / 2];
}

GlTexture grid_texture(const MarchGrid& grid) {
  const Int3 size{grid.dims[0] + 2 * MarchGrid::pad, grid.dims[1] + 2 * MarchGrid::pad,
                  grid.dims[2] + 2 * MarchGrid::pad};
  std::vector<float> texels;
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y) {
      const auto row =
          grid.value.begin() +
          static_cast<std::ptrdiff_t>(grid.at(-MarchGrid::pad, y - MarchGrid::pad, z - MarchGrid::pad));
      texels.insert(texels.end(), row, row + size[0]);
    }
  GlTexture texture = make_texture({.width = size[0], .height = size[1], .depth = size[2]}, texels.data());
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

// One scene at one size, seen by one quality.
struct Measured {
  BenchContext context{0};
  const FieldScene& field;
  int size, rounds;
  std::shared_ptr<GpuDevice> gpu;
  SampledScene sampled;
  Camera camera;
  Scene scene;
  RenderOptions options;
  std::unique_ptr<ImageStorage> truth;
  static constexpr int stride = 8;

  Measured(const FieldScene& of, int pixels, Quality quality, std::shared_ptr<GpuDevice> by, int repeats)
      : field(of), size(pixels), rounds(repeats), gpu(std::move(by)),
        sampled(sample_scene(of, LatticeKind::bcc, "default")), camera(scene_camera(of, pixels, 0)),
        scene(splat_scene(of, sampled, camera)) {
    options.quality = quality, options.backend = Backend::gpu, options.gpu = gpu;
    truth = true_image(field, sampled, camera, options, size, stride);
  }
  [[nodiscard]] double db(const Image& image) const {
    return image_error(image, truth->image, stride).psnr();
  }

  // A picture by the library, through all its layers.
  Row library(const char* name, Backend backend) {
    options.backend = backend;
    Drawers drawers;
    ImageStorage image(size, size);
    const double first = median_ms(1, [&] {
      scene.drawers = &drawers;
      (void)render(scene, options, context.get(), image.image);
    });
    const double whole = median_ms(rounds, [&] { (void)render(scene, options, context.get(), image.image); });
    return row(name, -1, whole, first, db(image.image));
  }

  // Drawing alone, of sites or (grid) of a texture.
  Row drawing(const char* name, const MarchGrid* grid) {
    ImageStorage image(size, size);
    options.backend = Backend::gpu;
    SettledPicture picture(scene, options, context.get(), image.image);
    picture.settle_level(), picture.settle_view(), picture.settle_look();
    const Shot& shot = picture.shot();
    const FieldBricks bricks =
        make_field_bricks(*shot.slice, brick_border(shot.slice->kernel.space), context.get());
    const ClassTable table = gpu_table(shot, change_at_sites(*shot.slice, context.get()));
    GpuPixels pixels;
    double ms = 0;
    gpu->run([&] {
      GpuSites sites(bricks, gpu->info());
      ShaderKind kind = shader_kind(shot, table);
      if (grid)
        sites.sites = GpuBricks(grid_texture(*grid)), kind.gather = texture_gather(*grid, *shot.slice),
        kind.ripple = false;
      const GpuClasses classes(table_texels(table), bricks, unseen_by(shot, table, bricks));
      GpuPicture drawn(gpu->programs(), kind, picture_block(shot, table, bricks), sites, classes, {});
      const auto draw = [&] {
        for (int y = 0; y < size; y += drawn.rows_at_once())
          drawn.draw_rows(y, std::min(drawn.rows_at_once(), size - y));
        glFinish();
      };
      draw(); // compiles
      ms = median_ms(rounds, draw);
      pixels = drawn.read(false);
    });
    for (size_t p = 0; p < pixels.color.size(); ++p)
      std::copy_n(pixels.color[p].begin(), 4, image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * p));
    return row(name, ms, -1, -1, db(image.image));
  }

  [[nodiscard]] Row row(const char* name, double draw, double whole, double first, double error) const {
    const auto ms = [](const char* column, double value) {
      return value < 0 ? word(column, "-") : figure(column, value, 2);
    };
    return {word("scene", field.name),
            figure("sites, M", static_cast<double>(sampled.slice.sites()) / 1e6, 1),
            figure("pixels a side", size, 0),
            figure("step, T", quality_settings(options.quality).sheet_step, 2),
            word("by", name),
            ms("drawing ms", draw),
            ms("picture ms", whole),
            ms("first ms", first),
            figure("dB to the truth", error, 1)};
  }
};

void measure(const FieldScene& field, int size, const std::shared_ptr<GpuDevice>& gpu, int rounds,
             std::vector<Row>& rows) {
  const Int3 dims{field.samples, field.samples, field.samples};
  const auto value = [&](double x, double y, double z) { return field.field({x, y, z}, nullptr); };
  const MarchGrid linear = make_march_grid(dims, value),
                  cubic = make_march_grid(dims, value, Interpolation::tricubic);
  for (const Quality quality : {Quality::draft, Quality::normal}) {
    Measured m(field, size, quality, gpu, rounds);
    rows.push_back(m.drawing("gather of BCC sites", nullptr));
    rows.push_back(m.drawing("trilinear texture", &linear));
    rows.push_back(m.drawing("tricubic texture", &cubic));
    rows.push_back(m.library("the library, GPU", Backend::gpu));
    rows.push_back(m.library("the library, CPU", Backend::cpu));
  }
}

} // namespace

int run_gpu_suite(std::span<const std::string> args, const Report& report) {
  GpuWishes wishes;
  wishes.software_too = true;
  bool moments = false, beside = false;
  for (const std::string& arg : args) {
    if (arg == "--fragment")
      wishes.entry = GpuEntry::fragment;
    else if (arg == "--moments")
      moments = true;
    else if (arg == "--beside-cpu")
      beside = true;
    else
      fail(Code::invalid_argument, "gpu: --fragment, --moments or --beside-cpu, not ", arg);
  }
  const auto gpu = std::make_shared<GpuDevice>(wishes);
  const GpuInfo& info = gpu->info();
  report.out << info.renderer << ", OpenGL " << info.version
             << (info.entry == GpuEntry::compute ? ", compute\n" : ", fragments\n");
  if (beside) {
    report.table("Pictures by a GPU and by the CPU", compare_with_cpu(gpu, report.quick));
    return 0;
  }
  constexpr int small = 128, large = 256, few_pixels = 512, many_pixels = 1024, rounds = 15;
  constexpr int quick_samples = 40, quick_pixels = 64;
  if (!moments) {
    std::vector<Row> rows;
    if (report.quick) {
      measure(smoke_scene(quick_samples), quick_pixels, gpu, 1, rows);
    } else {
      measure(marschner_lobb_scene(small), few_pixels, gpu, rounds, rows);
      measure(waves_scene(large), many_pixels, gpu, rounds, rows);
    }
    report.table("Pictures by a GPU", rows);
  }
  report.table("Moments of a series by a GPU", report.quick
                                                   ? measure_moments(quick_samples, quick_pixels, gpu, 2)
                                                   : measure_moments(large, few_pixels, gpu, rounds));
  return 0;
}

} // namespace bccsplat::bench
