// SPDX-License-Identifier: Apache-2.0
// Axes of space whose samples are unevenly spaced. The field lives in index space; the world is laid out by
// even positions, which run from 0 to n - 1 like indices and are in proportion to the coordinates. Between
// samples a monotone cubic leads from one to the other (time_axis.h; formats/bcc4.md, record 0x8009).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/vec.h"
#include "points/time_axis.h"

namespace bccsplat {

// Returns where samples of these coordinates stand, from 0 to their number less 1.
[[nodiscard]] std::vector<double> even_positions(std::span<const double> coordinates);

// One of them.
struct UnevenAxis {
  TimeAxis even;              // even positions by indices
  double end = 0;             // of indices and of even positions
  double closest = 1;         // least slope
  std::vector<double> halves; // even positions of the indices i + 1/2
};

class UnevenAxes {
 public:
  UnevenAxes() = default;
  // Coordinates along x, y and z, as checked: strictly monotone, at least two; none for an even axis.
  explicit UnevenAxes(const std::array<std::vector<double>, 3>& coordinates);

  [[nodiscard]] bool uneven(size_t axis) const { return axes_[axis].has_value(); }
  [[nodiscard]] bool any() const { return uneven(0) || uneven(1) || uneven(2); }
  // Beyond the outermost samples both go on straight, as steep as they are there.
  [[nodiscard]] double even_of(size_t axis, double index) const;
  [[nodiscard]] double index_of(size_t axis, double even) const;
  [[nodiscard]] Vec3 even_of(const Vec3& index) const;
  [[nodiscard]] Vec3 index_of(const Vec3& even) const;
  // Returns d even / d index, above 0.
  [[nodiscard]] double slope_at(size_t axis, double index) const;
  [[nodiscard]] Vec3 slopes_at(const Vec3& index) const;
  // Returns the index of an even position, rounded to the sample whose half-way marks it lies between; halves
  // are rounded up.
  [[nodiscard]] int64_t nearest_sample(size_t axis, double even) const;
  // Returns the least slope of an axis: how close samples stand where they stand closest; at most 1.
  [[nodiscard]] double closest(size_t axis) const;

 private:
  std::array<std::optional<UnevenAxis>, 3> axes_;
};

} // namespace bccsplat
