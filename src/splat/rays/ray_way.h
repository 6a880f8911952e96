// SPDX-License-Identifier: Apache-2.0
// The way of parallel rays through the cells that may hold a value.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "splat/rays/ray_lanes.h"
#include "splat/rays/surface_cells.h"
#include "splat/view/view.h"

namespace bccsplat {

// The way of orthographic rays through a slice without clips, whose cells and view must outlive it: a slab of
// blocks after the other, whole layers of cells at a time. Slabs are numbered along the rays.
class RayWay {
 public:
  RayWay(const SurfaceCells& cells, const Slice& slice, const SheetView& view, const Context& context);

  // False where nothing can be met in the square of pixels around it.
  [[nodiscard]] bool any(int i, int j) const { return any_[square_at(i, j)] != 0; }
  // Returns a bit for each slab that may hold something in that square, 64 a word.
  [[nodiscard]] std::span<const uint64_t> slabs(int i, int j) const {
    const size_t words = words_;
    return {&slabs_[square_at(i, j) * words], words};
  }
  [[nodiscard]] size_t words() const { return words_; }

  // The rays of the piece of a picture from pixel (i, j) on: the sheets that they are in the domain at, and
  // in a slab the layers of cells that they pass a bit in; a bit for each ray that has any.
  [[nodiscard]] uint64_t find_intervals(int i, int j, PieceIntervals& intervals) const;
  [[nodiscard]] uint64_t find_layers(int i, int j, int slab, std::span<uint64_t, piece_rays> layers) const;

  // Calls sheets(from, to) for the layers of a slab, in the order of the ray, those beside each other as one:
  // sheet numbers that the ray from `at`, sheet 0, is in them between.
  template<class Body> void each_run(const Vec3& at, int slab, uint64_t layers, const Body& sheets) const {
    const double first = (block_edge * along(slab) - at[axes_[2]] * planes_) * per_plane_;
    for (const auto& [begin, end] : runs_[layers])
      if (begin != end) sheets(first + begin * per_plane_, first + end * per_plane_);
  }

  // Returns at least the number of sheets that bound a ray's layers in a slab.
  [[nodiscard]] size_t most_sheets() const {
    return static_cast<size_t>(block_edge * std::fabs(per_plane_)) + 3;
  }

 private:
  static constexpr int parts = SlabArgs::parts;
  using Masks = SlabArgs::Masks;
  // The times at which a ray enters and leaves layers beside each other, of all that are passed; at most two.
  using Runs = std::array<std::array<int, 2>, 2>;
  void make_runs();
  void make_masks(double slope, size_t across, Masks& masks) const;
  void find_slabs(const Slice& slice, const SheetView& view, const Context& context);
  [[nodiscard]] size_t square_at(int i, int j) const {
    return static_cast<size_t>(j >> shift_) * squares_ + (i >> shift_);
  }
  [[nodiscard]] size_t at(int u, int v, int w) const {
    return u * stride_[0] + v * stride_[1] + w * stride_[2];
  }
  [[nodiscard]] int along(int slab) const { return direction_ > 0 ? slab : blocks_[2] - 1 - slab; }

  const SurfaceCells& cells_;
  const SheetView& view_;
  DrawnBox box_;
  double planes_;                            // per lattice unit
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
  std::array<Runs, 1 << block_edge> runs_{};
};

} // namespace bccsplat
