// SPDX-License-Identifier: Apache-2.0
// The same picture by the CPU and by either entry of the GPU, and how near they are.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "base/error.h"
#include "tests/support/gpu.h"
#include "tests/support/splat_scene.h"

namespace bccsplat::test {

inline constexpr double least_db = 45;
inline constexpr int pixels = 64;

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

  std::shared_ptr<GpuDevice> gpu_;
  std::unique_ptr<ImageStorage> cpu, gpu;
};

inline std::string entry_name(const testing::TestParamInfo<GpuEntry>& p) {
  return p.param == GpuEntry::compute ? "compute" : "fragment";
}

} // namespace bccsplat::test
