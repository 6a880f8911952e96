// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/ray_march/march_spline.h"

#include <algorithm>
#include <cmath>

namespace bccsplat::bench {
namespace {

// The recursive prefilter (Unser 1999) along `count` lines of n values side by side: value i of line j is at
// values[i * count + j].
void filter_lines(std::vector<double>& values, size_t n, size_t count) {
  if (n == 1) return; // a constant is its own coefficient
  const double pole = std::sqrt(3.0) - 2;
  const size_t period = 2 * (n - 1);
  const auto mirrored = [&](size_t i) { return i < n ? i : period - i; };
  double* const v = values.data();
  for (size_t j = 0; j < count; ++j) { // what the recursion would have come to from minus infinity
    double sum = 0, power = 1;
    for (size_t i = 0; i < std::min<size_t>(period, 60); ++i, power *= pole)
      sum += power * v[mirrored(i) * count + j];
    v[j] = sum / (1 - std::pow(pole, static_cast<double>(period)));
  }
  for (size_t i = 1; i < n; ++i)
    for (size_t j = 0; j < count; ++j) v[i * count + j] += pole * v[(i - 1) * count + j];
  for (size_t j = 0; j < count; ++j) {
    double& last = v[(n - 1) * count + j];
    last = pole / (pole * pole - 1) * (last + pole * v[(n - 2) * count + j]);
  }
  for (size_t i = n - 1; i-- > 0;)
    for (size_t j = 0; j < count; ++j) v[i * count + j] = pole * (v[(i + 1) * count + j] - v[i * count + j]);
  for (double& c : values) c *= 6;
}

// Coefficients fall away from where the samples end, down to numbers so small that processors are slow with
// them.
float without_tail(double c) { return std::fabs(c) < 1e-30 ? 0.0f : static_cast<float>(c); }

} // namespace

void make_spline_coefficients(MarchGrid& grid) {
  const std::array<size_t, 3> stride{1, grid.row, grid.plane};
  constexpr size_t at_once = 64;
  std::vector<double> lines;
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t beside = axis == 0 ? 1 : 0, third = 3 - axis - beside;
    const auto length = [&](size_t a) { return static_cast<size_t>(grid.dims[a]); };
    const size_t n = length(axis);
    for (size_t k = 0; k < length(third); ++k)
      for (size_t first = 0; first < length(beside); first += at_once) {
        const size_t count = std::min(at_once, length(beside) - first);
        float* const corner = grid.value.data() + grid.origin + k * stride[third] + first * stride[beside];
        lines.resize(n * count);
        for (size_t i = 0; i < n; ++i)
          for (size_t j = 0; j < count; ++j)
            lines[i * count + j] = corner[i * stride[axis] + j * stride[beside]];
        filter_lines(lines, n, count);
        for (size_t i = 0; i < n; ++i)
          for (size_t j = 0; j < count; ++j)
            corner[i * stride[axis] + j * stride[beside]] = without_tail(lines[i * count + j]);
      }
  }
}

std::array<float, 2> spline_bounds(const MarchGrid& grid, const Int3& cell) {
  constexpr size_t edge = MarchGrid::cell_edge, taps = edge + 3, points = 3 * edge + 1;
  // Control values of the cubic pieces along an axis from coefficients -1 .. edge + 1: at, a third and two
  // thirds behind each sample.
  const auto control = [](const float* from, size_t stride, size_t i) {
    const auto c = [&](size_t n) { return from[(i / 3 + n) * stride]; };
    if (i % 3 == 0) return (c(0) + 4 * c(1) + c(2)) * (1.0f / 6);
    return i % 3 == 1 ? (2 * c(1) + c(2)) * (1.0f / 3) : (c(1) + 2 * c(2)) * (1.0f / 3);
  };
  std::array<float, points * taps * taps> along_x;
  std::array<float, points * points * taps> along_y;
  Int3 first, last; // samples of the cell
  for (size_t a = 0; a < 3; ++a) {
    first[a] = cell[a] * static_cast<int>(edge);
    last[a] = std::min(first[a] + static_cast<int>(edge), std::max(grid.dims[a] - 1, first[a]));
  }
  const auto count = [&](size_t a) { return static_cast<size_t>(last[a] - first[a]); };
  const size_t nx = 3 * count(0) + 1, ny = 3 * count(1) + 1, nz = 3 * count(2) + 1;
  for (size_t k = 0; k < count(2) + 3; ++k)
    for (size_t j = 0; j < count(1) + 3; ++j) {
      const float* const row = grid.value.data() + grid.at(first[0] - 1, first[1] - 1 + static_cast<int>(j),
                                                           first[2] - 1 + static_cast<int>(k));
      for (size_t i = 0; i < nx; ++i) along_x[(k * taps + j) * points + i] = control(row, 1, i);
    }
  for (size_t k = 0; k < count(2) + 3; ++k)
    for (size_t j = 0; j < ny; ++j)
      for (size_t i = 0; i < nx; ++i)
        along_y[(k * points + j) * points + i] = control(&along_x[k * taps * points + i], points, j);
  float low = INFINITY, high = -INFINITY;
  for (size_t k = 0; k < nz; ++k)
    for (size_t j = 0; j < ny; ++j)
      for (size_t i = 0; i < nx; ++i) {
        const float c = control(&along_y[j * points + i], points * points, k);
        low = std::min(low, c), high = std::max(high, c);
      }
  return {low, high};
}

} // namespace bccsplat::bench
