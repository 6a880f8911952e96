// SPDX-License-Identifier: Apache-2.0
// The way of parallel rays through the cells that may hold a value.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "splat/rays/surface_cells.h"
#include "splat/view/view.h"

namespace bccsplat {

// The way of orthographic rays through a slice without clips, whose cells and view must outlive it: a slab of
// blocks after the other, whole layers of cells at a time. Slabs are numbered along the rays.
class RayWay {
 public:
  RayWay(const SurfaceCells& cells, const Slice& slice, const SheetView& view, const Context& context);

  struct Ray {
    Vec3 at{};                  // sheet 0, lattice units
    double u = 0, v = 0, w = 0; // planes, at sheet 0
    double enter = 0, leave = 0;
    const uint64_t* slabs = nullptr; // that may hold something
    int slab = 0, end = 0;           // the next slab, and that after the last
  };
  // False where nothing can be met in the square of pixels around it.
  [[nodiscard]] bool any(int i, int j) const { return any_[square_at(i, j)] != 0; }
  // False where it misses the domain.
  bool begin(int i, int j, Ray& ray) const;

  // Moves on to the next slab in which the ray passes a bit; returns its layers, 0 where there is none.
  uint32_t advance(Ray& ray) const;
  // Calls sheets(from, to) for the layers, in the order of the ray, those beside each other as one: sheet
  // numbers that it is in them between.
  template<class Body> void each_run(const Ray& ray, uint32_t layers, const Body& sheets) const {
    const double first = (block_edge * along(ray.slab) - ray.w) * per_plane_;
    const auto run = [&](int begin, int end) {
      const double a = first + begin * per_plane_, b = first + end * per_plane_;
      sheets(std::min(a, b), std::max(a, b));
    };
    if (direction_ > 0) {
      for (int n = 0; layers >> n != 0;) {
        const int begin = n + std::countr_zero(layers >> n), end = begin + std::countr_one(layers >> begin);
        run(begin, end);
        n = end;
      }
    } else {
      const auto width = [](uint32_t bits) { return static_cast<int>(std::bit_width(bits)); };
      for (int end = width(layers); end > 0; end = width(layers)) {
        const int begin = width(~layers & ((1u << end) - 1));
        run(begin, end);
        layers &= (1u << begin) - 1;
      }
    }
  }

  // At least the number of sheets that bound a ray's layers in a slab.
  [[nodiscard]] size_t most_sheets() const {
    return static_cast<size_t>(block_edge * std::fabs(per_plane_)) + 3;
  }

 private:
  static constexpr int parts = 8; // of a cell, that masks are for
  using Masks = std::array<uint64_t, 2 * block_edge * parts>;
  void make_masks(double slope, size_t across, Masks& masks) const;
  void find_slabs(const Slice& slice, const SheetView& view, const Context& context);
  [[nodiscard]] size_t square_at(int i, int j) const {
    return static_cast<size_t>(j >> shift_) * static_cast<size_t>(squares_) +
           static_cast<size_t>(i >> shift_);
  }
  [[nodiscard]] size_t at(int u, int v, int w) const {
    return static_cast<size_t>(u) * stride_[0] + static_cast<size_t>(v) * stride_[1] +
           static_cast<size_t>(w) * stride_[2];
  }
  [[nodiscard]] int along(int slab) const { return direction_ > 0 ? slab : blocks_[2] - 1 - slab; }

  const SurfaceCells& cells_;
  const SheetView& view_;
  DrawnBox box_;
  double planes_;                            // per lattice unit
  Vec3 per_unit_{};                          // sheets per lattice unit along each axis
  std::array<size_t, 3> axes_{0, 1, 2};      // u, v across the rays, w along them
  Int3 blocks_{};                            // along u, v, w
  std::array<size_t, 3> stride_{};           // words from block to block
  std::array<uint64_t, block_edge> layer_{}; // the bits of a layer of cells along w
  double slope_u_ = 0, slope_v_ = 0;         // planes per plane
  double per_plane_ = 1;                     // sheets
  int direction_ = 1;
  int shift_ = 3;               // squares have 2^shift pixels a side
  int squares_ = 0, words_ = 0; // squares in a row; words of a square's slabs
  Reservation memory_;
  std::vector<uint64_t> slabs_;
  std::vector<uint8_t> any_;
  Masks mask_u_{}, mask_v_{};
};

} // namespace bccsplat
