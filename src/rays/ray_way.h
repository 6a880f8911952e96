// SPDX-License-Identifier: Apache-2.0
// The way of rays through the cells that may hold a value.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "rays/cell_marker.h"
#include "rays/ray_axes.h"
#include "rays/ray_lanes.h"
#include "rays/surface_cells.h"
#include "view/view.h"

namespace bccsplat {

// Where the picture of some cells is, pixels.
struct PixelBox {
  double i0 = 0, i1 = 0, j0 = 0, j1 = 0;
};

// The rays of a piece, and which cells they may pass in a block.
struct PieceWay {
  PieceRays rays;
  const PassMasks *u = nullptr, *v = nullptr;
};

// The way of rays through a slice without clips, whose cells and view must outlive it: a slab of blocks after
// the other, whole layers of cells at a time. Slabs are numbered along the rays.
class RayWay {
 public:
  // axis: of all rays that it is asked about. marker: of cells that wait to be marked, as layers are asked
  // for.
  RayWay(const SurfaceCells& cells, const Slice& slice, const SheetView& view, const RayAxis& axis,
         const Context& context, CellMarker* marker = nullptr);

  // False where nothing can be met in the square of pixels around it.
  [[nodiscard]] bool any(int i, int j) const { return any_[square_at(i, j)] != 0; }
  // Returns a bit for each slab that may hold something in that square, 64 a word.
  [[nodiscard]] std::span<const uint64_t> slabs(int i, int j) const {
    const size_t words = words_;
    return {&slabs_[square_at(i, j) * words], words};
  }
  [[nodiscard]] size_t words() const { return words_; }

  // The rays of the piece of a picture from pixel (i, j) on, a bit for each that meets the domain; and in a
  // slab the layers of cells that they pass a bit in, a bit for each ray that has any.
  [[nodiscard]] uint64_t find_rays(int i, int j, PieceWay& piece) const;
  [[nodiscard]] uint64_t find_layers(const PieceWay& piece, int slab,
                                     std::span<uint64_t, piece_rays> layers) const;

  // Calls sheets(from, to) for the layers of a slab, in the order of ray n, those beside each other as one:
  // sheet numbers that the ray is in them between.
  template<class Body>
  void each_run(const PieceRays& rays, size_t n, int slab, uint64_t layers, const Body& sheets) const {
    const double per_plane = rays.per_plane[n], first = rays.first[n] + block_edge * along(slab) * per_plane;
    for (const auto& [begin, end] : runs_[layers])
      if (begin != end) sheets(first + begin * per_plane, first + end * per_plane);
  }

  // Returns at least the number of sheets that bound a ray's layers in a slab.
  [[nodiscard]] size_t most_sheets() const { return most_sheets_; }

 private:
  // The times at which a ray enters and leaves layers beside each other, of all that are passed; at most two.
  using Runs = std::array<std::array<int, 2>, 2>;
  // Masks of pieces whose smallest slopes lie from low + n pitches on, for each n.
  struct Masks {
    double low = 0, per_pitch = 0;
    std::vector<PassMasks> of_pitch;
    [[nodiscard]] const PassMasks* of(const PieceRays::Doubles& slope) const;
  };
  void make_runs();
  void make_masks(const RayAxis::Across& across, const Context& context, Masks& masks);
  void find_slabs(const SheetView& view, const Context& context);
  void add_slabs(const PixelBox& picture, int first, int last);
  void add_waiting(const SheetView& view, const Context& context);
  [[nodiscard]] std::array<int, 2> blocks_across(const PieceRays::Across& across, size_t n, int place) const;
  [[nodiscard]] size_t square_at(int i, int j) const {
    return static_cast<size_t>(j >> shift_) * squares_ + (i >> shift_);
  }
  [[nodiscard]] size_t at(int u, int v, int w) const {
    return u * stride_[0] + v * stride_[1] + w * stride_[2];
  }
  [[nodiscard]] int along(int slab) const { return direction_ > 0 ? slab : blocks_[2] - 1 - slab; }

  const SurfaceCells& cells_;
  CellMarker* marker_;
  const SheetView& view_;
  DrawnBox box_;
  double plane_;                             // lattice units
  std::array<size_t, 3> axes_{0, 1, 2};      // u, v across the rays, w along them
  Int3 blocks_{};                            // along u, v, w
  std::array<size_t, 3> stride_{};           // words from block to block
  std::array<uint64_t, block_edge> layer_{}; // the bits of a layer of cells along w
  int direction_ = 1;
  size_t most_sheets_ = 0;
  int shift_ = 3;                          // squares have 2^shift pixels a side
  int squares_ = 0, rows_ = 0, words_ = 0; // squares in a row, and rows of them; words of a square's slabs
  Reservation memory_;
  std::vector<Reservation> masks_memory_;
  std::vector<uint64_t> slabs_;
  std::vector<uint8_t> any_;
  Masks masks_u_, masks_v_;
  std::array<Runs, 1 << block_edge> runs_{};
};

} // namespace bccsplat
