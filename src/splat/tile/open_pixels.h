// SPDX-License-Identifier: Apache-2.0
// Which pixels of a tile are still open: sums over rectangles of its ring's samples, so that what only
// finished pixels would see is not drawn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/grid.h"
#include "splat/plan/plan.h"

namespace bccsplat {

// Sums are made anew when one in so many of the open pixels has closed since: making them takes a few percent
// of a picture (tests/bench/notes/splat.md), and older ones hide fewer points. No measurement of the part is
// noted.
inline constexpr int closed_part = 16;
// Points that were hidden since their transform are dropped where less than one part in so many of a tile is
// open: above it the four reads per point cost more than they save (tests/bench/notes/splat.md, skips).
inline constexpr int mostly_closed_part = 4;

class OpenPixels {
 public:
  void prepare(const PlannedTile& tile, const SplatPlan& plan);
  // Returns whether sums of the one serve the other: each pixel follows the same sample of the same ring.
  [[nodiscard]] bool counts_like(const OpenPixels& other) const;

  // Makes the sums anew from open(p) of each pixel p = row * pitch + column. A pixel counts at the sample
  // that it follows.
  template<class Open> void count(int pitch, const Open& open) {
    const int columns = ring_width_ + 1;
    sum_.assign(columns * (ring_height_ + 1), 0);
    for (int y = 0; y < height_; ++y) {
      const size_t first = plane_index(0, y, pitch);
      int32_t* const before = before_.data() + 1;
      for (int x = 0; x < width_; ++x) before[x] = open(first + x) ? 1 : 0;
      for (int x = 0; x < width_; ++x) before[x] += before[x - 1];
      int32_t* const row = sum_.data() + (row_[y] + 1) * columns;
      for (int x = 0; x < columns; ++x) row[x] += before_[pixels_[x]];
    }
    for (int y = 1; y <= ring_height_; ++y) {
      const int32_t* const above = sum_.data() + (y - 1) * columns;
      int32_t* const row = sum_.data() + y * columns;
      for (int x = 0; x < columns; ++x) row[x] += above[x];
    }
  }

  // Returns whether no pixel is open whose sample is inside the rectangle of samples of the picture (x begin,
  // y begin, x end, y end), or within around() of it; of a fan: no pixel inside the rectangle of pixels.
  [[nodiscard]] bool hidden(const std::array<int, 4>& rect) const;
  // Returns whether all of those pixels are open.
  [[nodiscard]] bool all_open(const std::array<int, 4>& rect) const;
  [[nodiscard]] bool mostly_closed() const { return sum_.back() < width_ * height_ / mostly_closed_part; }
  [[nodiscard]] const int32_t* sums() const { return sum_.data(); } // see TransformArgs::open_sum
  [[nodiscard]] int around() const { return around_; }

 private:
  // Returns the rectangle and what is within around() of it, as x begin, y begin, x end, y end in the ring.
  [[nodiscard]] std::array<int, 4> in_ring(const std::array<int, 4>& rect) const;
  [[nodiscard]] int open(const std::array<int, 4>& in_ring) const; // pixels

  int ring_x_ = 0, ring_y_ = 0, ring_width_ = 0, ring_height_ = 0;
  int width_ = 0, height_ = 0, around_ = 0;
  // The "ring" of a fan is the tile itself.
  std::vector<int> pixels_; // of a row of the tile that follow samples before a column of the ring
  std::vector<int> row_;    // of the ring that a row of pixels follows
  std::vector<int> rows_;   // of pixels that follow samples before a row of the ring
  std::vector<int32_t> before_, sum_;
};

} // namespace bccsplat
