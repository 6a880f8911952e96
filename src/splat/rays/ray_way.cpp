// SPDX-License-Identifier: Apache-2.0
// A ray passes a slab of blocks within at most two blocks along either axis across. Which cells of a block it
// may pass follows from where it is at the slab's one side: masks by that place, one for each axis across, of
// all rays that are there in an eighth of a cell. The blocks' pictures tell which slabs a square of pixels
// may need at all.
#include "splat/rays/ray_way.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace bccsplat {
namespace {

// The whole number below x, which is no further than this below 0.
constexpr int below_zero = 1 << 16;
int floor_of(double x) { return static_cast<int>(x + below_zero) - below_zero; }

} // namespace

RayWay::RayWay(const SurfaceCells& cells, const Slice& slice, const SheetView& view, const Context& context)
    : cells_(cells), view_(view), box_(drawn_box(slice)), planes_(1 / slice.lattice.plane_distance()) {
  size_t along = 0;
  for (size_t a = 1; a < 3; ++a)
    if (std::fabs(view.ez[a]) > std::fabs(view.ez[along])) along = a;
  axes_ = {along == 0 ? size_t{1} : size_t{0}, along == 2 ? size_t{1} : size_t{2}, along};
  const std::array<size_t, 3> stride{1, static_cast<size_t>(cells.blocks[0]),
                                     static_cast<size_t>(cells.blocks[0]) * cells.blocks[1]};
  for (size_t n = 0; n < 3; ++n) blocks_[n] = cells.blocks[axes_[n]], stride_[n] = stride[axes_[n]];
  for (size_t bit = 0; bit < 64; ++bit) layer_[bit >> (2 * along) & 3] |= uint64_t{1} << bit;
  const double plane = slice.lattice.plane_distance();
  const double ahead = view.ez[along];
  slope_u_ = view.ez[axes_[0]] / ahead, slope_v_ = view.ez[axes_[1]] / ahead;
  per_plane_ = plane / ahead;
  direction_ = ahead > 0 ? 1 : -1;
  make_masks(slope_u_, axes_[0], mask_u_);
  make_masks(slope_v_, axes_[1], mask_v_);
  make_runs();
  find_slabs(slice, view, context);
}

void RayWay::make_runs() {
  for (unsigned layers = 0; layers < runs_.size(); ++layers) {
    size_t count = 0;
    for (int begin = 0; layers >> begin != 0; ++begin) {
      if ((layers >> begin & 1) == 0) continue;
      const int end = begin + std::countr_one(layers >> begin);
      runs_[layers][count++] = {begin, end};
      begin = end;
    }
    if (direction_ > 0) continue;
    for (auto& run : runs_[layers]) std::swap(run[0], run[1]);
    if (count == 2) std::swap(runs_[layers][0], runs_[layers][1]);
  }
}

// Entry n: rays whose smallest coordinate in the slab is between n and n + 1 parts, less a block.
void RayWay::make_masks(double slope, size_t across, Masks& masks) const {
  constexpr double margin = 1e-6;
  const double s = std::fabs(slope);
  const auto coordinate = [](size_t bit, size_t axis) { return static_cast<int>(bit >> (2 * axis) & 3); };
  for (size_t n = 0; n < masks.size(); ++n) {
    masks[n] = 0;
    const double from = static_cast<double>(n) / parts - block_edge;
    for (size_t bit = 0; bit < 64; ++bit) {
      const int layer = coordinate(bit, axes_[2]), cell = coordinate(bit, across);
      const int step = slope >= 0 ? layer : block_edge - 1 - layer;
      if (cell >= static_cast<int>(std::floor(from + s * step - margin)) &&
          cell <= static_cast<int>(std::floor(from + 1.0 / parts + s * (step + 1) + margin)))
        masks[n] |= uint64_t{1} << bit;
    }
  }
}

// Of each square of pixels, the slabs that hold a block whose picture touches the square.
void RayWay::find_slabs(const Slice& slice, const SheetView& view, const Context& context) {
  constexpr int most_squares = 512; // along either side
  while (std::max(view.width, view.height) >> shift_ >= most_squares) ++shift_;
  const double plane = slice.lattice.plane_distance(), half = 0.5 * block_edge * plane;
  squares_ = ((view.width - 1) >> shift_) + 1;
  const int rows = ((view.height - 1) >> shift_) + 1;
  words_ = (blocks_[2] + 63) / 64;
  const size_t count = static_cast<size_t>(squares_) * rows;
  const size_t words = count * words_;
  memory_ = Reservation(context.memory, words * sizeof(uint64_t) + count, "the way of rays");
  any_.assign(count, 0);
  slabs_.assign(words, 0);
  // Where voxels are no cubes rays are aslant to the sheets, and a column drifts with depth.
  const Vec3 depth = (1 / view.step) * view.normal;
  const Vec3 gx = view.gx - dot(view.gx, view.ez) * depth, gy = view.gy - dot(view.gy, view.ez) * depth;
  constexpr double margin = 0.01; // pixels
  double reach_x = margin, reach_y = margin;
  for (size_t a = 0; a < 3; ++a) reach_x += half * std::fabs(gx[a]), reach_y += half * std::fabs(gy[a]);
  const auto [u, v, w] = axes_;
  const double step = 2 * half, per_square = 1.0 / (1 << shift_);
  // The number of a square, from the one before the picture to the one behind it.
  const auto square = [&](double pixel, int squares) {
    return floor_of(std::clamp(pixel * per_square, -1.0, static_cast<double>(squares)));
  };
  Vec3 p;
  for (int z = 0; z < blocks_[2]; ++z) {
    context.progress.check();
    for (int y = 0; y < blocks_[1]; ++y) {
      p[u] = half, p[v] = half + step * y, p[w] = half + step * z;
      const double x0 = dot(gx, p - view.eye), y0 = dot(gy, p - view.eye);
      const int order = along(z);
      const size_t word = order / 64;
      const uint64_t* const row = &cells_.bits[at(0, y, z)];
      for (int x = 0; x < blocks_[0]; ++x) {
        if (row[static_cast<size_t>(x) * stride_[0]] == 0) continue;
        const double i = x0 + x * step * gx[u], j = y0 + x * step * gy[u];
        const int i0 = std::max(square(i - reach_x, squares_), 0),
                  i1 = std::min(square(i + reach_x, squares_), squares_ - 1),
                  j0 = std::max(square(j - reach_y, rows), 0),
                  j1 = std::min(square(j + reach_y, rows), rows - 1);
        for (int t = j0; t <= j1; ++t)
          for (int s = i0; s <= i1; ++s) {
            const size_t n = static_cast<size_t>(t) * squares_ + s;
            any_[n] = 1;
            slabs_[n * words_ + word] |= uint64_t{1} << (order % 64);
          }
      }
    }
  }
}

uint64_t RayWay::find_intervals(int i, int j, PieceIntervals& intervals) const {
  return bccsplat::find_intervals({view_.sample(i, j, 0), view_.ex, view_.ey, view_.ez, box_.begin, box_.end},
                                  intervals);
}

uint64_t RayWay::find_layers(int i, int j, int slab, std::span<uint64_t, piece_rays> layers) const {
  constexpr double margin = 1e-6; // blocks
  const double per_block = planes_ / block_edge;
  const int place = along(slab);
  const Vec3 at = view_.sample(i, j, 0);
  const auto axis = [&](size_t n, double slope, const Masks& masks) {
    const auto across = [&](const Vec3& v) { return (v[axes_[n]] - slope * v[axes_[2]]) * per_block; };
    return SlabArgs::Axis{blocks_[n],       stride_[n],
                          &masks,           across(at) + slope * place + std::min(0.0, slope) - margin,
                          across(view_.ex), across(view_.ey)};
  };
  const SlabArgs args{&cells_.bits[this->at(0, 0, place)], axis(0, slope_u_, mask_u_),
                      axis(1, slope_v_, mask_v_), layer_};
  return bccsplat::find_layers(args, layers);
}

} // namespace bccsplat
