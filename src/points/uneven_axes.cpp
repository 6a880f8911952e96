// SPDX-License-Identifier: Apache-2.0
#include "points/uneven_axes.h"

#include <algorithm>
#include <utility>

namespace bccsplat {
namespace {

constexpr double half = 0.5;
// Where the slope is looked at between two samples.
constexpr int slopes_per_sample = 8;
constexpr double slope_distance = 1.0 / slopes_per_sample;
// Positions this little before a half-way mark belong to it: rounding of conversions.
constexpr double half_rounding = 1e-9;

} // namespace

std::vector<double> even_positions(std::span<const double> coordinates) {
  const double last = static_cast<double>(coordinates.size()) - 1;
  const double whole = coordinates.back() - coordinates.front();
  std::vector<double> even;
  for (const double c : coordinates) even.push_back(last * ((c - coordinates.front()) / whole));
  return even;
}

UnevenAxes::UnevenAxes(const std::array<std::vector<double>, 3>& coordinates) {
  for (size_t a = 0; a < 3; ++a) {
    if (coordinates[a].empty()) continue;
    const std::vector<double> even = even_positions(coordinates[a]);
    UnevenAxis axis;
    axis.even = TimeAxis(even);
    axis.end = static_cast<double>(even.size()) - 1;
    for (size_t i = 0; i + 1 < even.size(); ++i) {
      for (int k = 0; k <= slopes_per_sample; ++k)
        axis.closest =
            std::min(axis.closest, axis.even.slope_at(static_cast<double>(i) + k * slope_distance));
      axis.halves.push_back(axis.even.time_of(static_cast<double>(i) + half));
    }
    axes_[a] = std::move(axis);
  }
}

double UnevenAxes::even_of(size_t axis, double index) const {
  const auto& a = axes_[axis];
  if (!a) return index;
  if (!(index > 0)) return index * a->even.slope_at(0);
  return index < a->end ? a->even.time_of(index) : a->end + (index - a->end) * a->even.slope_at(a->end);
}

double UnevenAxes::index_of(size_t axis, double even) const {
  const auto& a = axes_[axis];
  if (!a) return even;
  if (!(even > 0)) return even / a->even.slope_at(0);
  return even < a->end ? a->even.index_of(even) : a->end + (even - a->end) / a->even.slope_at(a->end);
}

Vec3 UnevenAxes::even_of(const Vec3& index) const {
  return {even_of(0, index[0]), even_of(1, index[1]), even_of(2, index[2])};
}

Vec3 UnevenAxes::index_of(const Vec3& even) const {
  return {index_of(0, even[0]), index_of(1, even[1]), index_of(2, even[2])};
}

double UnevenAxes::slope_at(size_t axis, double index) const {
  const auto& a = axes_[axis];
  return a ? a->even.slope_at(std::clamp(index, 0.0, a->end)) : 1;
}

Vec3 UnevenAxes::slopes_at(const Vec3& index) const {
  return {slope_at(0, index[0]), slope_at(1, index[1]), slope_at(2, index[2])};
}

int64_t UnevenAxes::nearest_sample(size_t axis, double even) const {
  const std::vector<double>& halves = axes_[axis]->halves;
  return std::upper_bound(halves.begin(), halves.end(), even + half_rounding) - halves.begin();
}

double UnevenAxes::closest(size_t axis) const { return axes_[axis] ? axes_[axis]->closest : 1; }

} // namespace bccsplat
