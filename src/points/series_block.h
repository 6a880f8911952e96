// SPDX-License-Identifier: Apache-2.0
// A box of the samples of a series: what one of several processes writes. Parts of a series are boxes of some
// frames through all of space, blocks are parts whose boxes are smaller in space as well.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "points/sample_source.h"

namespace bccsplat {

// Source samples begin .. end - 1 along x, y, z and t. Ends of UINT32_MAX are those of the series.
struct SeriesBlock {
  static constexpr uint32_t to_the_end = UINT32_MAX;
  std::array<uint32_t, 4> begin{}, end{to_the_end, to_the_end, to_the_end, to_the_end};

  // Frames first .. end - 1 through all of space.
  [[nodiscard]] static SeriesBlock of_frames(uint32_t first, uint32_t end) {
    return {{0, 0, 0, first}, {to_the_end, to_the_end, to_the_end, end}};
  }
  [[nodiscard]] uint32_t first_frame() const { return begin[3]; }
  [[nodiscard]] uint32_t end_frame() const { return end[3]; }
  [[nodiscard]] bool has_frame(uint32_t frame) const { return frame >= begin[3] && frame < end[3]; }
  [[nodiscard]] bool all_space() const {
    return std::all_of(begin.begin(), begin.begin() + 3, [](uint32_t b) { return b == 0; }) &&
           std::all_of(end.begin(), end.begin() + 3, [](uint32_t e) { return e == to_the_end; });
  }
  [[nodiscard]] bool empty() const {
    for (size_t a = 0; a < 4; ++a)
      if (begin[a] >= end[a]) return true;
    return false;
  }
  // Returns what both have; maybe nothing.
  [[nodiscard]] SeriesBlock cut(const SeriesBlock& other) const {
    SeriesBlock both;
    for (size_t a = 0; a < 4; ++a) {
      both.begin[a] = std::max(begin[a], other.begin[a]);
      both.end[a] = std::min(end[a], other.end[a]);
    }
    return both;
  }
  [[nodiscard]] static SeriesBlock whole(const std::array<uint32_t, 4>& dims) { return {{}, dims}; }
  bool operator==(const SeriesBlock&) const = default;
};

// Returns what is left of a box without another one: up to eight boxes.
[[nodiscard]] std::vector<SeriesBlock> without(SeriesBlock box, const SeriesBlock& taken);

// Returns the bricks of a block on a lattice of its series: those whose first site stands at one of its
// samples, or between these and its end. Blocks that share the samples among them share the bricks, at every
// level. Some blocks have no brick.
[[nodiscard]] BrickBox bricks_of(const SeriesBlock& block, const Lattice4& lattice);

// Returns the bricks that have sites within so many sites of a sample of the block, along each axis.
[[nodiscard]] BrickBox bricks_near(const SeriesBlock& block, const Lattice4& lattice, int32_t sites);

} // namespace bccsplat
