// SPDX-License-Identifier: Apache-2.0
#include "field/sparse_grid.h"

#include <algorithm>
#include <tuple>

namespace bccsplat {

SparseGrid::SparseGrid(std::vector<GridValue> values) {
  const auto brick = [](const GridValue& v) {
    return std::array{v.at[2] / edge, v.at[1] / edge, v.at[0] / edge};
  };
  std::stable_sort(values.begin(), values.end(), [&](const GridValue& a, const GridValue& b) {
    const auto x = brick(a), y = brick(b);
    return x != y ? x < y : std::tuple(a.at[2], a.at[1], a.at[0]) < std::tuple(b.at[2], b.at[1], b.at[0]);
  });
  for (size_t i = 0; i < values.size(); ++i) {
    const Int3& p = values[i].at;
    if (i > 0 && p == values[i - 1].at) {
      values_.back() += values[i].value;
      continue;
    }
    if (const auto key = brick(values[i]); keys_.empty() || keys_.back() != key) {
      keys_.push_back(key);
      Brick& b = bricks_.emplace_back();
      for (size_t a = 0; a < 3; ++a) b.begin[a] = p[a] / edge * edge;
      b.first = static_cast<uint32_t>(values_.size());
    }
    auto& row = bricks_.back().row[p[2] % edge * edge + p[1] % edge];
    row = static_cast<uint16_t>(row | 1u << (p[0] % edge));
    values_.push_back(values[i].value);
  }
  values_.shrink_to_fit();
  for (Brick& b : bricks_) {
    for (size_t r = 0; r < b.row.size(); ++r) {
      b.before[r] = static_cast<uint16_t>(b.count);
      b.count += std::popcount(b.row[r]);
    }
    for (uint32_t n = b.first; n < b.first + b.count; ++n)
      b.low = std::min(b.low, values_[n]), b.high = std::max(b.high, values_[n]);
    range_ = {std::min(range_[0], b.low), std::max(range_[1], b.high)};
  }
}

uint64_t SparseGrid::bytes() const {
  return keys_.size() * sizeof(keys_[0]) + bricks_.size() * sizeof(Brick) + values_.size() * sizeof(float);
}

} // namespace bccsplat
