// SPDX-License-Identifier: Apache-2.0
// Values at few points of a 3D grid, in bricks of 16^3 that are found, bounded and left out as a whole.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "points/grid_value.h"

namespace bccsplat {

class SparseGrid {
 public:
  static constexpr int edge = 16;
  struct Brick {
    Int3 begin{}; // its first point
    uint32_t first = 0, count = 0;
    float low = 0, high = 0; // of its values, and 0
    // By row z * 16 + y: the x that hold a value, and how many values earlier rows hold.
    std::array<uint16_t, edge * edge> row{}, before{};
  };

  SparseGrid() = default;
  // Values of one point add up, in their order. No coordinate is negative.
  explicit SparseGrid(std::vector<GridValue> values);

  [[nodiscard]] bool empty() const { return values_.empty(); }
  [[nodiscard]] size_t size() const { return values_.size(); }
  [[nodiscard]] const std::vector<Brick>& bricks() const { return bricks_; } // by z, y, x
  [[nodiscard]] uint64_t bytes() const;
  // Smallest and largest value, and 0.
  [[nodiscard]] std::array<float, 2> range() const { return range_; }
  // The value of a point of the grid; null: none.
  [[nodiscard]] const float* find(int x, int y, int z) const {
    const std::array<int32_t, 3> key{z / edge, y / edge, x / edge};
    const auto at = std::lower_bound(keys_.begin(), keys_.end(), key);
    if (at == keys_.end() || *at != key) return nullptr;
    const Brick& b = bricks_[at - keys_.begin()];
    const size_t r = z % edge * edge + y % edge;
    const unsigned bits = b.row[r], bit = 1u << (x % edge);
    if (!(bits & bit)) return nullptr;
    return &values_[b.first + b.before[r] + std::popcount(bits & (bit - 1))];
  }
  // Calls body(point, value) for the values of a brick, x fastest.
  template<class Body> void each(const Brick& b, const Body& body) const {
    const float* value = values_.data() + b.first;
    for (int r = 0; r < edge * edge; ++r)
      for (unsigned bits = b.row[r]; bits; bits &= bits - 1)
        body(Int3{b.begin[0] + std::countr_zero(bits), b.begin[1] + r % edge, b.begin[2] + r / edge},
             *value++);
  }
  template<class Body> void each(const Body& body) const {
    for (const Brick& b : bricks_) each(b, body);
  }

 private:
  std::vector<std::array<int32_t, 3>> keys_; // of the bricks: z, y, x in bricks
  std::vector<Brick> bricks_;
  std::vector<float> values_;
  std::array<float, 2> range_{};
};

} // namespace bccsplat
