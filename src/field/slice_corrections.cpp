// SPDX-License-Identifier: Apache-2.0
#include "field/slice_corrections.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace bccsplat {
namespace {

constexpr double same_point = 1e-6; // a point this close to one of the grid is meant to be it
constexpr double rounding = 1e-9;   // sums of steps miss a whole index by less

// Samples of one axis of a grid, by where they lie.
class AxisPlaces {
 public:
  AxisPlaces(double from, double step, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
      double p = from + step * i;
      const double near = std::nearbyint(p);
      if (std::fabs(p - near) < rounding) p = near; // a whole index, whatever its sum rounded to
      places_.emplace_back(p, static_cast<size_t>(i));
    }
    std::sort(places_.begin(), places_.end());
  }
  // Calls body(sample, distance) for the samples less than 1 from a point.
  template<class Body> void around(int32_t point, const Body& body) const {
    auto at = std::upper_bound(places_.begin(), places_.end(), std::pair{point - 1.0, SIZE_MAX});
    for (; at != places_.end() && at->first < point + 1.0; ++at) body(at->second, at->first - point);
  }

 private:
  std::vector<std::pair<double, size_t>> places_;
};

} // namespace

float SliceCorrections::at(const Vec3& uvw, Vec3* gradient) const {
  if (gradient) *gradient = {};
  if (add.empty()) return 0;
  const FallOff fall(shape);
  std::array<std::array<double, 2>, 3> weight, slope;
  Int3 cell;
  for (size_t a = 0; a < 3; ++a) {
    const double p = uvw[a] - origin[a];
    if (!(p > -1 && p < INT32_MAX)) return 0;
    cell[a] = static_cast<int32_t>(std::floor(p));
    for (size_t k = 0; k < 2; ++k) {
      const double d = p - cell[a] - static_cast<double>(k);
      weight[a][k] = fall.value(d), slope[a][k] = fall.slope(d);
    }
  }
  float sum = 0;
  for (size_t corner = 0; corner < 8; ++corner) {
    const std::array<size_t, 3> k{corner & 1, corner >> 1 & 1, corner >> 2};
    Int3 at;
    for (size_t a = 0; a < 3; ++a) at[a] = cell[a] + static_cast<int32_t>(k[a]);
    const double wx = weight[0][k[0]], wy = weight[1][k[1]], wz = weight[2][k[2]];
    const Vec3 slopes{slope[0][k[0]] * wy * wz, wx * slope[1][k[1]] * wz, wx * wy * slope[2][k[2]]};
    if ((wx * wy * wz == 0 && slopes == Vec3{}) || at[0] < 0 || at[1] < 0 || at[2] < 0) continue;
    const float* value = add.find(at[0], at[1], at[2]);
    if (!value) continue;
    sum += *value * static_cast<float>(wx * wy * wz);
    if (gradient) *gradient = *gradient + *value * slopes;
  }
  return sum;
}

const float* SliceCorrections::set_at(const Vec3& uvw) const {
  if (set.empty()) return nullptr;
  Int3 at;
  for (size_t a = 0; a < 3; ++a) {
    const double p = uvw[a] - origin[a], near = std::nearbyint(p);
    if (!(std::fabs(p - near) < same_point && near >= 0 && near < INT32_MAX)) return nullptr;
    at[a] = static_cast<int32_t>(near);
  }
  return set.find(at[0], at[1], at[2]);
}

void SliceCorrections::add_to_grid(const Vec3& from, const Vec3& step, const Int3& dims,
                                   float* values) const {
  if (empty()) return;
  const FallOff fall(shape);
  const AxisPlaces x(from[0] - origin[0], step[0], dims[0]), y(from[1] - origin[1], step[1], dims[1]),
      z(from[2] - origin[2], step[2], dims[2]);
  const size_t nx = dims[0], ny = dims[1];
  // Calls body(sample, distances) for the samples a point reaches.
  const auto around = [&](const Int3& at, const auto& body) {
    z.around(at[2], [&](size_t k, double dz) {
      y.around(at[1], [&](size_t j, double dy) {
        x.around(at[0], [&](size_t i, double dx) { body((k * ny + j) * nx + i, Vec3{dx, dy, dz}); });
      });
    });
  };
  add.each([&](const Int3& at, float value) {
    around(at, [&](size_t sample, const Vec3& d) {
      values[sample] += value * static_cast<float>(fall.value(d[0]) * fall.value(d[1]) * fall.value(d[2]));
    });
  });
  set.each([&](const Int3& at, float value) {
    around(at, [&](size_t sample, const Vec3& d) {
      const bool same = std::max({std::fabs(d[0]), std::fabs(d[1]), std::fabs(d[2])}) < same_point;
      if (same && std::isnan(values[sample])) values[sample] = value;
    });
  });
}

} // namespace bccsplat
