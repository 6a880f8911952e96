// SPDX-License-Identifier: Apache-2.0
// Coefficients of the cubic B-spline by a recursion along each axis, mirrored at the faces; 64 of them a
// place.
#include "motion/spline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace bccsplat::motion {
namespace {

// Four neighbours along x in a vector, which compilers do not find by themselves.
using Four = float __attribute__((vector_size(16)));
Four load(const float* from) {
  Four v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
float sum(Four v) { return (v[0] + v[1]) + (v[2] + v[3]); }

const float pole = std::sqrt(3.f) - 2;
constexpr float nothing = 1e-9f; // of the largest coefficient
constexpr int32_t horizon = 12;  // pole^12 is 1e-7

int32_t mirrored(int32_t i, int32_t n) {
  if (n == 1) return 0;
  const int32_t period = 2 * (n - 1), p = ((i % period) + period) % period;
  return p < n ? p : period - p;
}

// Makes coefficients of n rows of samples, `stride` apart, each of `width` lanes side by side.
void prefilter(float* rows, int32_t n, size_t stride, size_t width) {
  if (n == 1) return;
  std::vector<float> first(width, 0);
  float power = 1;
  for (int32_t k = 0; k < horizon; ++k, power *= pole)
    for (size_t j = 0; j < width; ++j) first[j] += power * rows[mirrored(k, n) * stride + j];
  std::copy(first.begin(), first.end(), rows);
  for (int32_t i = 1; i < n; ++i)
    for (size_t j = 0; j < width; ++j) rows[i * stride + j] += pole * rows[(i - 1) * stride + j];
  float* const last = rows + (n - 1) * stride;
  for (size_t j = 0; j < width; ++j) last[j] = pole / (pole * pole - 1) * (last[j] + pole * last[j - stride]);
  for (int32_t i = n - 2; i >= 0; --i)
    for (size_t j = 0; j < width; ++j)
      rows[i * stride + j] = pole * (rows[(i + 1) * stride + j] - rows[i * stride + j]);
  for (int32_t i = 0; i < n; ++i)
    for (size_t j = 0; j < width; ++j) rows[i * stride + j] *= 6;
}

using Weights = std::array<float, 4>;

Weights spline_weights(float f) {
  const float g = 1 - f;
  return {g * g * g / 6, (4 - 3 * f * f * (2 - f)) / 6, (4 - 3 * g * g * (2 - g)) / 6, f * f * f / 6};
}
Weights slope_weights(float f) {
  const float g = 1 - f;
  return {-g * g / 2, f * (3 * f - 4) / 2, -g * (3 * g - 4) / 2, f * f / 2};
}

// The first coefficient that a place takes, and how far the place is from its sample.
struct Cell {
  int32_t first;
  float share;
};
Cell cell(float place, int32_t n) {
  const float at = std::clamp(place, 0.f, static_cast<float>(n - 1));
  const int32_t first = std::min(static_cast<int32_t>(at), std::max(n - 2, 0));
  return {first, at - static_cast<float>(first)};
}

} // namespace

Spline::Spline(const Box& box)
    : dims_(box.dims), row_(box.dims[0] + 3), plane_(row_ * (box.dims[1] + 3)),
      coefficients_(plane_ * (box.dims[2] + 3)) {
  const auto [nx, ny, nz] = box.dims;
  const auto at = [&](int32_t x, int32_t y, int32_t z) {
    return coefficients_.data() + (z + 1) * plane_ + (y + 1) * row_ + (x + 1);
  };
  for (int32_t z = 0; z < nz; ++z)
    for (int32_t y = 0; y < ny; ++y) {
      std::copy_n(box.values.data() + box.index(0, y, z), nx, at(0, y, z));
      prefilter(at(0, y, z), nx, 1, 1);
    }
  for (int32_t z = 0; z < nz; ++z) prefilter(at(0, 0, z), ny, row_, nx);
  prefilter(at(0, 0, 0), nz, plane_, plane_ - 3 * row_ - 3);
  // Tails die away over dozens of samples; processors are slow where they are nearly 0.
  float largest = 0;
  for (const float c : coefficients_) largest = std::max(largest, std::abs(c));
  for (float& c : coefficients_)
    if (std::abs(c) < nothing * largest) c = 0;
  for (int32_t z = 0; z < nz; ++z) {
    for (int32_t y = 0; y < ny; ++y)
      for (const int32_t x : {-1, nx, nx + 1}) *at(x, y, z) = *at(mirrored(x, nx), y, z);
    for (const int32_t y : {-1, ny, ny + 1}) std::copy_n(at(-1, mirrored(y, ny), z), row_, at(-1, y, z));
  }
  for (const int32_t z : {-1, nz, nz + 1}) std::copy_n(at(-1, -1, mirrored(z, nz)), plane_, at(-1, -1, z));
}

float Spline::value(const Float3& place) const {
  const Cell x = cell(place[0], dims_[0]), y = cell(place[1], dims_[1]), z = cell(place[2], dims_[2]);
  const Weights wx = spline_weights(x.share), wy = spline_weights(y.share), wz = spline_weights(z.share);
  const float* p = coefficients_.data() + z.first * plane_ + y.first * row_ + x.first;
  Four sums{};
  for (size_t k = 0; k < 4; ++k, p += plane_)
    sums += wz[k] * ((wy[0] * load(p) + wy[1] * load(p + row_)) +
                     (wy[2] * load(p + 2 * row_) + wy[3] * load(p + 3 * row_)));
  return sum(sums * load(wx.data()));
}

float Spline::value_and_gradient(const Float3& place, Float3& gradient) const {
  const Cell x = cell(place[0], dims_[0]), y = cell(place[1], dims_[1]), z = cell(place[2], dims_[2]);
  const Weights wx = spline_weights(x.share), wy = spline_weights(y.share), wz = spline_weights(z.share);
  const Weights dx = slope_weights(x.share), dy = slope_weights(y.share), dz = slope_weights(z.share);
  const float* p = coefficients_.data() + z.first * plane_ + y.first * row_ + x.first;
  Four values{}, along_y{}, along_z{};
  for (size_t k = 0; k < 4; ++k, p += plane_) {
    Four plane{}, slope{};
    for (size_t j = 0; j < 4; ++j) {
      const Four row = load(p + j * row_);
      plane += wy[j] * row, slope += dy[j] * row;
    }
    values += wz[k] * plane, along_y += wz[k] * slope, along_z += dz[k] * plane;
  }
  const Four by_x = load(wx.data());
  gradient = {sum(values * load(dx.data())), sum(along_y * by_x), sum(along_z * by_x)};
  return sum(values * by_x);
}

} // namespace bccsplat::motion
