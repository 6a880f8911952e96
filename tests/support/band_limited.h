// SPDX-License-Identifier: Apache-2.0
// Fields known everywhere, with a stated band: plane waves of a ball, and the test signal of Marschner &
// Lobb.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/vec.h"
#include "lattice/lattice.h"
#include "points/brick.h"
#include "tests/support/plane_waves.h"

namespace bccsplat::test {

// Positions of the sites of a layer in source index units. A static lattice has one layer per coset.
inline Grid4 layer_grid(const Lattice4& lattice, int32_t layer) {
  const int coset = lattice.coset(layer);
  const Int3 n = lattice.space.dims(coset);
  Grid4 grid;
  for (size_t a = 0; a < 3; ++a)
    for (int32_t i = 0; i < n[a]; ++i)
      grid[a].push_back(lattice.space.plane(coset, i) * lattice.space_step[a]);
  grid[3] = {lattice.layer_frame(layer)};
  return grid;
}

// Marschner & Lobb 1994, An evaluation of reconstruction filters for volume rendering, section 5, on [-1,
// 1]^3: (1 - sin(pi z / 2) + a (1 + cos(2 pi f cos(pi r / 2)))) / (2 (1 + a)), r^2 = x^2 + y^2, f = 6, a =
// 1/4. It is a function of z plus one of (x, y). `cut` > 0 keeps the frequencies of the latter below `cut`
// cycles per unit: the function on [-2, 2]^2, continued as its mirror image, in a cosine series. Its z part
// has a single frequency, so the result is limited to a ball.
class MarschnerLobb {
 public:
  explicit MarschnerLobb(double cut = 0) {
    if (cut <= 0) return;
    terms_ = static_cast<int>(std::floor(4 * cut)) + 1;
    constexpr int n = 512; // midpoints of [0, 2]; both factors are even
    const size_t count = terms_;
    std::vector<double> cosine(count * n), half(count * n), square(size_t{n} * n);
    const auto at = [](int i) { return (i + 0.5) * 2 / n; };
    for (int m = 0; m < terms_; ++m)
      for (int i = 0; i < n; ++i)
        cosine[m * n + i] = (m ? 2.0 : 1.0) / n * std::cos(m * std::numbers::pi / 2 * at(i));
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) square[j * n + i] = ring(std::hypot(at(i), at(j)));
    for (size_t m = 0; m < count; ++m)
      for (size_t j = 0; j < n; ++j)
        for (size_t i = 0; i < n; ++i) half[m * n + j] += cosine[m * n + i] * square[j * n + i];
    series_.resize(count * count);
    for (size_t m = 0; m < count; ++m)
      for (size_t k = 0; k < count; ++k) {
        if (static_cast<double>(m * m + k * k) > 16 * cut * cut) continue;
        for (size_t j = 0; j < n; ++j) series_[k * count + m] += cosine[k * n + j] * half[m * n + j];
      }
  }
  [[nodiscard]] double operator()(const Vec3& p) const {
    return (1 - std::sin(std::numbers::pi * p[2] / 2) + alpha * (1 + in_plane(p[0], p[1]))) /
           (2 * (1 + alpha));
  }

 private:
  static constexpr double alpha = 0.25;
  static double ring(double r) {
    return std::cos(2 * std::numbers::pi * 6 * std::cos(std::numbers::pi * r / 2));
  }
  [[nodiscard]] double in_plane(double x, double y) const {
    if (terms_ == 0) return ring(std::hypot(x, y));
    const size_t count = terms_;
    std::vector<double> along(count);
    for (size_t m = 0; m < count; ++m) along[m] = std::cos(static_cast<double>(m) * std::numbers::pi / 2 * x);
    double sum = 0;
    for (size_t k = 0; k < count; ++k) {
      double row = 0;
      for (size_t m = 0; m < count; ++m) row += series_[k * count + m] * along[m];
      sum += row * std::cos(static_cast<double>(k) * std::numbers::pi / 2 * y);
    }
    return sum;
  }
  int terms_ = 0;
  std::vector<double> series_;
};

} // namespace bccsplat::test
