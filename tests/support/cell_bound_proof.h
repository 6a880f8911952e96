// SPDX-License-Identifier: Apache-2.0
// The proof of the bounds in rays/cell_bound.h: largest sums on a fine grid, and what sums between its points
// may have more.
//
// With r_i(x) = K(x - s_i) - trilinear of K(corner - s_i) and m the middle of the coefficients, the
// difference is sum r_i (c_i - m) + m sum r_i: no more than half the range times the largest sum |r_i|, and
// |m| times the largest |sum r_i|. All cubes of the plane grid are mirror images of each other: two of the
// eight corners are sites, one of either coset, across the cube from each other.
//
// Between points of a grid of pitch h, r_i differs from its own trilinear interpolation by at most h^2 / 8
// times the three largest |d^2 K / d x_a^2|: trilinear functions have none, and K has slopes without a jump.
// The sum of |trilinear| is largest at points of the grid.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/vec.h"
#include "rays/cell_bound.h"

namespace bccsplat::test {

// Returns at least the kernel's largest second derivative in any direction: 2 phi' + 4 t phi'', t between 0
// and r^2, phi being a function of r^2.
inline double largest_bend(const RadialKernel& kernel) {
  const double square = kernel.radius * kernel.radius;
  double third = 0; // of the polynomial's third and second derivatives
  for (int j = 2; j < kernel.terms; ++j)
    third += std::fabs(kernel.a[j]) * j * (j - 1) * (6 + 4 * std::max(j - 2, 0));
  constexpr int steps = 1 << 18;
  double most = 0;
  for (int n = 0; n <= steps; ++n) {
    const double u = static_cast<double>(n) / steps;
    double first = 0, second = 0;
    for (int j = kernel.terms - 1; j >= 1; --j) {
      first = first * u + j * kernel.a[j];
      if (j >= 2) second = second * u + j * (j - 1) * kernel.a[j];
    }
    const double across = -2 / square * first, along = across + 4 * (1 - u) / square * second;
    most = std::max({most, std::fabs(across), std::fabs(along)});
  }
  return most + third / square / (2 * steps);
}

// It takes a tenth of a second.
inline CellBound prove_cell_bound(const RadialKernel& kernel, int parts) {
  const double plane = std::sqrt(0.5), reach = kernel.radius / plane;
  const int fine = 64 / parts, points = fine * parts; // along an edge of the cube
  std::vector<Vec3> sites;
  for (int z = -5; z <= 6; ++z)
    for (int y = -5; y <= 6; ++y)
      for (int x = -5; x <= 6; ++x) {
        if (((x ^ y) & 1) != 0 || ((x ^ z) & 1) != 0) continue;
        double square = 0;
        for (const int p : {x, y, z}) square += std::pow(std::max({-p, p - 1, 0}), 2);
        if (square < reach * reach) sites.push_back({1.0 * x, 1.0 * y, 1.0 * z});
      }
  const auto weight = [&](const Vec3& at, const Vec3& site) {
    const Vec3 d = plane * (at - site);
    return kernel.value(dot(d, d));
  };
  CellBound bound;
  // Axes are alike.
  for (int k = 0; k <= points; ++k)
    for (int j = 0; j <= k; ++j)
      for (int i = 0; i <= j; ++i) {
        const std::array<int, 3> n{i, j, k};
        Vec3 at, low, part;
        for (size_t a = 0; a < 3; ++a) {
          const int cube = std::min(n[a] / fine, parts - 1);
          at[a] = static_cast<double>(n[a]) / points;
          low[a] = static_cast<double>(cube) / parts;
          part[a] = static_cast<double>(n[a] - cube * fine) / fine;
        }
        double range = 0, middle = 0;
        for (const Vec3& site : sites) {
          double r = weight(at, site);
          for (size_t c = 0; c < 8; ++c) {
            double share = 1;
            Vec3 corner = low;
            for (size_t a = 0; a < 3; ++a) {
              share *= (c >> a & 1) != 0 ? part[a] : 1 - part[a];
              if ((c >> a & 1) != 0) corner[a] += 1.0 / parts;
            }
            if (share != 0) r -= share * weight(corner, site);
          }
          range += std::fabs(r), middle += r;
        }
        bound.of_range = std::max(bound.of_range, range);
        bound.of_middle = std::max(bound.of_middle, std::fabs(middle));
      }
  const double pitch = plane / points;
  const double between = static_cast<double>(sites.size()) * 3 * largest_bend(kernel) * pitch * pitch / 8;
  bound.of_range += between, bound.of_middle += between;
  return bound;
}

} // namespace bccsplat::test
