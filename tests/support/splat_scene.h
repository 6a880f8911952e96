// SPDX-License-Identifier: Apache-2.0
// Small scenes for the tests of the renderer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "scene/picture.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"

namespace bccsplat::test {

using Field3 = std::function<double(double x, double y, double z)>;

// A static volume of dims samples on BCC (or CC), prefiltered for the kernel, in the world by `affine`.
inline Slice make_slice(const std::array<uint32_t, 3>& dims, const Field3& f, const char* kernel = "default",
                        const Affine3& affine = {}, double air = 0, LatticeKind kind = LatticeKind::bcc,
                        const LatticeScales& scales = {1, 1, 1, 1}) {
  TestContext context;
  const auto lattice = Lattice4::fit(kind, {dims[0], dims[1], dims[2], 1}, scales);
  const auto samples = sample_field(
      lattice, [&](const Vec4& p) { return f(p[0], p[1], p[2]); }, air);
  const Coefficients c(samples, 0, make_kernel(kernel), 0, 1u << 30);
  return time_slice(c, 0, {0, 0}, affine, context.get());
}

// Marschner & Lobb's test signal on [0, n-1]^3, in [0, 1]; `frequency` 6 and spacing of 41 samples are the
// original.
inline Field3 marschner_lobb(double n, double frequency = 6) {
  return [=](double x, double y, double z) {
    const double u = 2 * x / (n - 1) - 1, v = 2 * y / (n - 1) - 1, w = 2 * z / (n - 1) - 1;
    const double r = std::hypot(u, v), alpha = 0.25;
    const double rho = std::cos(2 * std::numbers::pi * frequency * std::cos(std::numbers::pi * r / 2));
    return (1 - std::sin(std::numbers::pi * w / 2) + alpha * (1 + rho)) / (2 * (1 + alpha));
  };
}

inline TransferFunction ramp_function(double from, double to, double opacity) {
  TransferFunction f;
  f.colors = {{from, {0.2, 0.3, 0.9}}, {0.5 * (from + to), {0.3, 0.8, 0.3}}, {to, {0.9, 0.3, 0.1}}};
  f.opacities = {{from, 0}, {to, opacity}};
  return f;
}

inline Scene make_scene(const Slice& slice, const TransferFunction& function, const Camera& camera) {
  Scene scene;
  scene.slice = &slice;
  scene.camera = camera;
  scene.function = function;
  return scene;
}

inline RenderStats draw(const Scene& scene, const RenderOptions& options, ImageStorage& out,
                        int threads = 2) {
  TestContext context(threads);
  return render(scene, options, context.get(), out.image);
}

inline bool same_bits(const ImageStorage& a, const ImageStorage& b) {
  const auto same = [](const std::vector<float>& x, const std::vector<float>& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0);
  };
  return same(a.rgba, b.rgba) && same(a.depth, b.depth) && same(a.value, b.value) && same(a.time, b.time);
}

struct ImageError {
  double rmse = 0, most = 0;
  [[nodiscard]] double db() const { return -20 * std::log10(rmse); }
};
// Over RGBA of the pixels that either picture covers, peak 1.
inline ImageError compare(const ImageStorage& a, const ImageStorage& b) {
  ImageError e;
  double sum = 0;
  size_t count = 0;
  for (size_t p = 0; p < a.rgba.size(); p += 4) {
    if (a.rgba[p + 3] == 0 && b.rgba[p + 3] == 0) continue;
    for (size_t c = 0; c < 4; ++c) {
      const double d = static_cast<double>(a.rgba[p + c]) - b.rgba[p + c];
      sum += d * d, e.most = larger(e.most, std::fabs(d));
      ++count;
    }
  }
  e.rmse = count ? std::sqrt(sum / static_cast<double>(count)) : 0;
  return e;
}

} // namespace bccsplat::test
