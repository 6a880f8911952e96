// SPDX-License-Identifier: Apache-2.0
// The same picture by the CPU and by either entry of the GPU, how near they are, and what they are of.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "base/error.h"
#include "slice/time_slice.h"
#include "tests/support/gpu.h"
#include "tests/support/splat_scene.h"

namespace bccsplat::test {

inline constexpr double least_db = 45;
inline constexpr int pixels = 64;

// Corrections of both signs at every third sample of a corner, and one at each end of the grid.
inline std::shared_ptr<const SliceCorrections> make_corrections(CorrectionShape shape, float size,
                                                                const Int3& dims) {
  std::vector<GridValue> values{{{0, 0, 0}, size}, {{dims[0] - 1, dims[1] - 1, dims[2] - 1}, size}};
  for (int z = 4; z < dims[2] - 4; z += 3)
    for (int y = 4; y < dims[1] / 2; y += 3)
      for (int x = 4; x < dims[0] / 2; x += 3)
        values.push_back({{x, y, z}, (x + y + z) % 2 == 0 ? size : -size});
  return std::make_shared<const SliceCorrections>(
      SliceCorrections{{}, shape, SparseGrid(std::move(values)), {}});
}

inline Field3 ball() {
  return [](double x, double y, double z) {
    return 1.2 * std::exp(-0.012 * (std::pow(x - 19, 2) + std::pow(y - 15, 2) + std::pow(z - 16, 2)));
  };
}

// Waves of several lengths in a cloud that ends inside the box: most of its bricks are air.
inline Field3 smoke() {
  return [](double x, double y, double z) {
    const double r = std::hypot(x - 30, y - 22, z - 20) / 14;
    const double waves =
        1 + 0.4 * std::sin(0.9 * x + 0.3 * y) * std::sin(0.7 * z - 0.4 * x) + 0.3 * std::sin(1.1 * y);
    return std::max(0.0, 1 - r * r) * std::max(0.0, 1 - r * r) * waves;
  };
}

// A cloud that moves through a box.
inline double moving(const Vec4& p) {
  const double r = std::hypot(p[0] - 10 - p[3], p[1] - 14, p[2] - 12 + 0.3 * p[3]) / 9;
  return std::max(0.0, 1 - r * r) * (1 + 0.3 * std::sin(0.8 * p[0] + 0.2 * p[3]));
}

// A series in memory, cut at any moment.
struct MovingCloud {
  Lattice4 lattice;
  MemorySamples samples;
  Coefficients coefficients;
  TestContext context;

  explicit MovingCloud(LatticeKind kind, const char* kernel = "default", bool periodic = false,
                       double (*field)(const Vec4&) = moving)
      : lattice(Lattice4::fit(kind, {30, 28, 26, 12}, {1, 1, 1, 1}, 0, {}, periodic)),
        samples(sample_field(lattice, field, 0)),
        coefficients(samples, 0, make_kernel(kernel), 0, uint64_t{1} << 30), context(2) {}
  [[nodiscard]] Slice cut(double frame, bool later, double around = 0,
                          ThicknessKind kind = ThicknessKind::mean) {
    return thick_time_slice(coefficients, frame, {-around, around}, kind, {}, context.get(), later);
  }
};

class BothPictures : public testing::TestWithParam<GpuEntry> {
 protected:
  void SetUp() override {
    gpu_ = test_gpu(GetParam());
    if (!gpu_) GTEST_SKIP() << "no GPU";
  }

  // Draws a scene by both; returns how near they are.
  ImageError differ(const Scene& scene, RenderOptions o, int width = pixels, int height = pixels) {
    cpu = std::make_unique<ImageStorage>(width, height, true, true, true);
    gpu = std::make_unique<ImageStorage>(width, height, true, true, true);
    o.backend = Backend::cpu;
    (void)draw(scene, o, *cpu);
    o.backend = Backend::gpu, o.gpu = gpu_;
    const RenderStats stats = draw(scene, o, *gpu);
    EXPECT_STREQ(stats.drawer, "gpu");
    EXPECT_EQ(stats.gpu_failed, "");
    const ImageError e = compare(*cpu, *gpu);
    return e;
  }
  // The share of pixels whose planes are alike within `most`, or know nothing both.
  static double alike(const std::vector<float>& a, const std::vector<float>& b, double most) {
    size_t count = 0;
    for (size_t p = 0; p < a.size(); ++p)
      count += (std::isfinite(a[p]) ? std::fabs(static_cast<double>(a[p]) - b[p]) <= most
                                    : std::isfinite(a[p]) == std::isfinite(b[p]))
                   ? 1
                   : 0;
    return static_cast<double>(count) / static_cast<double>(a.size());
  }

  // How near two pictures of surfaces are without the few pixels whose rays graze one, or a face of the
  // domain: what they meet is decided by rounding.
  static double db_but_grazes(const ImageStorage& a, const ImageStorage& b) {
    constexpr size_t one_of = 100;
    std::vector<double> errors;
    for (size_t p = 0; p < a.rgba.size(); p += 4) {
      double sum = 0;
      for (size_t c = 0; c < 4; ++c) sum += std::pow(static_cast<double>(a.rgba[p + c]) - b.rgba[p + c], 2);
      if (a.rgba[p + 3] > 0 || b.rgba[p + 3] > 0) errors.push_back(sum / 4);
    }
    std::sort(errors.begin(), errors.end());
    errors.resize(errors.size() - errors.size() / one_of);
    const double mean =
        std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    return -10 * std::log10(mean);
  }

  // What a picture is refused with.
  static std::string refusal(const std::function<void()>& picture, Code code) {
    try {
      picture();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), code);
      return e.message();
    }
    return "";
  }

  std::shared_ptr<GpuDevice> gpu_;
  std::unique_ptr<ImageStorage> cpu, gpu;
};

inline std::string entry_name(const testing::TestParamInfo<GpuEntry>& p) {
  return p.param == GpuEntry::compute ? "compute" : "fragment";
}

} // namespace bccsplat::test
