// SPDX-License-Identifier: Apache-2.0
// A coefficient stands for the value at its site, a scattered point for its sample. Opacities are added up by
// planes of the lattice, along each axis, and the outermost planes that hold next to nothing of all are left
// out.
#include "scene/seen_box.h"

#include <algorithm>
#include <cmath>

#include "shade/class_table.h"

namespace bccsplat {
namespace {

constexpr int opacity_entries = 1024; // of the table of opacities
constexpr double specks = 1e-3;       // of all that is seen, on either side of an axis
constexpr double site_reach = 1.5;    // lattice units that a site shows beyond itself

// What is seen of each plane, by axis.
class SeenPlanes {
 public:
  SeenPlanes(const Slice& slice, const TransferFunction& function) : slice_(slice) {
    const auto [low, high] = slice.bounds;
    low_ = low, per_value_ = high > low ? (opacity_entries - 1) / (high - low) : 0;
    for (int i = 0; i < opacity_entries; ++i)
      opacity_.push_back(function.opacity(per_value_ > 0 ? low + i / per_value_ : low));
    for (size_t a = 0; a < 3; ++a) seen_[a].assign(slice.lattice.planes(a), 0.0);
    for (int c = 0; c < slice.lattice.cosets(); ++c)
      for (size_t s = 0; s < slice.coset[c].brick_slots(); ++s)
        if (const Brick* b = slice.coset[c].brick(s)) add(c, slice.coset[c].slot_position(s), *b);
    if (slice.scattered)
      slice.scattered->each_point(
          [&](const Vec3& at, float value, float share) { add(at, share * opacity(value)); });
  }

  [[nodiscard]] bool any() const { return total_ > 0; }
  // The first and the last plane that count.
  [[nodiscard]] std::array<size_t, 2> ends(size_t axis) const {
    const std::vector<double>& seen = seen_[axis];
    size_t first = 0, last = seen.size() - 1;
    for (double left = specks * total_; first < last && (left -= seen[first]) > 0;) ++first;
    for (double left = specks * total_; last > first && (left -= seen[last]) > 0;) --last;
    return {first, last};
  }

 private:
  [[nodiscard]] double opacity(float coefficient) const {
    const double at = (slice_.base + static_cast<double>(coefficient) - low_) * per_value_;
    return opacity_[static_cast<size_t>(std::clamp(at + 0.5, 0.0, opacity_entries - 1.0))];
  }
  // Counts a point that stands on no plane at the nearest plane of each axis.
  void add(const Vec3& at, double seen) {
    for (size_t a = 0; a < 3; ++a) {
      const double last = static_cast<double>(seen_[a].size()) - 1;
      seen_[a][static_cast<size_t>(
          std::clamp(std::round(at[a] / slice_.lattice.plane_distance()), 0.0, last))] += seen;
    }
    total_ += seen;
  }
  void add(int coset, const Int3& place, const Brick& brick) {
    const Int3 dims = slice_.coset[coset].dims();
    const auto plane = [&](size_t a, int32_t i) {
      return slice_.lattice.plane(coset, place[a] * brick_edge + i);
    };
    const auto end = [&](size_t a) { return std::min(brick_edge, dims[a] - place[a] * brick_edge); };
    for (int z = 0; z < end(2); ++z)
      for (int y = 0; y < end(1); ++y) {
        double row = 0;
        for (int x = 0; x < end(0); ++x) {
          const int site = (z * brick_edge + y) * brick_edge + x;
          if (brick.is_hole(site)) continue;
          const double seen = opacity(brick.value[site]);
          seen_[0][plane(0, x)] += seen, row += seen;
        }
        seen_[1][plane(1, y)] += row, seen_[2][plane(2, z)] += row, total_ += row;
      }
  }

  const Slice& slice_;
  double low_ = 0, per_value_ = 0, total_ = 0;
  std::vector<double> opacity_;
  std::array<std::vector<double>, 3> seen_;
};

} // namespace

WorldBox seen_box(const Slice& slice, const TransferFunction& function) {
  if (slice.empty()) return {};
  const DrawnBox whole = drawn_box(slice);
  if (function.opacity(slice.base) > 0 && slice.base == slice.air)
    return box_around(world_corners(slice, whole));
  const SeenPlanes planes(slice, function);
  if (!planes.any()) return box_around(world_corners(slice, whole));
  DrawnBox seen;
  for (size_t a = 0; a < 3; ++a) {
    const auto [first, last] = planes.ends(a);
    const double d = slice.lattice.plane_distance();
    seen.begin[a] = std::max(whole.begin[a], d * static_cast<double>(first) - site_reach);
    seen.end[a] = std::min(whole.end[a], d * static_cast<double>(last) + site_reach);
    if (!(seen.end[a] > seen.begin[a])) seen.begin[a] = whole.begin[a], seen.end[a] = whole.end[a];
  }
  return box_around(world_corners(slice, seen));
}

} // namespace bccsplat
