// SPDX-License-Identifier: Apache-2.0
// Where rays may meet a value: the cells that may hold it, a bit each, and the way of parallel rays through
// them.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "splat/view/view.h"
#include "tests/bench/rays/cell_ranges.h"

namespace bccsplat::bench {

// Blocks of cells along the axis that rays run along most: `w`; across it u and v. Bit (w 4 + v) 4 + u.
struct BlockBits {
  std::array<size_t, 3> axes{0, 1, 2}; // u, v, w
  Int3 blocks{};                       // along u, v, w
  std::vector<uint64_t> bits;          // of a block: u fastest
  [[nodiscard]] size_t at(int u, int v, int w) const {
    return static_cast<size_t>((w * blocks[1] + v) * blocks[0] + u);
  }
};

// all: every cell may hold it.
[[nodiscard]] BlockBits make_block_bits(const CellRanges& ranges, size_t along, double target, bool all);

// The way of orthographic rays: a slab of blocks after the other, whole layers of cells at a time. Slabs are
// numbered along the rays.
class BlockWay {
 public:
  BlockWay(const BlockBits& bits, const Slice& slice, const SheetView& view);

  struct Ray {
    double u = 0, v = 0, w = 0; // planes, at sheet 0
    double enter = 0, leave = 0;
    const uint64_t* slabs = nullptr; // that may hold something
    int slab = 0, end = 0;           // the next slab, and that after the last
  };
  // False where nothing can be met in a square of pixels that begins at multiples of `square`.
  [[nodiscard]] bool any(int i, int j) const { return any_[square_at(i, j)] != 0; }
  // False where it misses the domain.
  bool begin(const Slice& slice, const SheetView& view, int i, int j, Ray& ray) const;

  // Moves on to the next slab in which the ray passes a bit; returns its layers, 0 where there is none.
  uint32_t advance(Ray& ray) const;
  // Calls sheets(from, to) for the layers, in the order of the ray: sheet numbers that it is in them between.
  template<class Body> void each_layer(const Ray& ray, uint32_t layers, const Body& sheets) const {
    const double first = (block_edge * along(ray.slab) - ray.w) * per_plane_;
    for (int n = 0; n < block_edge; ++n) {
      const int layer = direction_ > 0 ? n : block_edge - 1 - n;
      if ((layers >> layer & 1) == 0) continue;
      const double from = first + (direction_ > 0 ? layer : layer + 1) * per_plane_;
      sheets(from, from + std::fabs(per_plane_));
    }
  }

  // At least the number of sheets that bound a ray's layers in a slab.
  [[nodiscard]] size_t most_sheets() const {
    return static_cast<size_t>(block_edge * std::fabs(per_plane_)) + 3;
  }

  static constexpr int square = 8; // pixels

 private:
  static constexpr int parts = 8; // of a cell, that masks are for
  using Masks = std::array<uint64_t, 2 * block_edge * parts>;
  void make_masks(double slope, int shift, Masks& masks) const;
  void find_slabs(const Slice& slice, const SheetView& view);
  [[nodiscard]] size_t square_at(int i, int j) const {
    return static_cast<size_t>(j / square * squares_ + i / square);
  }
  [[nodiscard]] int along(int slab) const { return direction_ > 0 ? slab : bits_.blocks[2] - 1 - slab; }

  const BlockBits& bits_;
  double slope_u_ = 0, slope_v_ = 0; // planes per plane
  double per_plane_ = 1;             // sheets
  int direction_ = 1;
  int squares_ = 0, words_ = 0; // squares in a row; words of a square's slabs
  std::vector<uint64_t> slabs_;
  std::vector<uint8_t> any_;
  Masks mask_u_{}, mask_v_{};
};

} // namespace bccsplat::bench
