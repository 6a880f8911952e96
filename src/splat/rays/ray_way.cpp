// SPDX-License-Identifier: Apache-2.0
// A ray passes a slab of blocks within at most two blocks along either axis across. Which cells of a block it
// may pass follows from where it is at the slab's one side: masks by that place, one for each axis across, of
// all rays that are there in an eighth of a cell. The blocks' pictures tell which slabs a square of pixels
// may need at all.
#include "splat/rays/ray_way.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace bccsplat {
namespace {

// The whole number below x, which is no further than this below 0.
constexpr int below_zero = 1 << 16;
int floor_of(double x) { return static_cast<int>(x + below_zero) - below_zero; }

} // namespace

RayWay::RayWay(const SurfaceCells& cells, const Slice& slice, const SheetView& view, const Context& context)
    : cells_(cells), view_(view), box_(drawn_box(slice)), planes_(1 / slice.lattice.plane_distance()) {
  for (size_t a = 0; a < 3; ++a) per_unit_[a] = view.ez[a] != 0 ? 1 / view.ez[a] : 0;
  size_t along = 0;
  for (size_t a = 1; a < 3; ++a)
    if (std::fabs(view.ez[a]) > std::fabs(view.ez[along])) along = a;
  axes_ = {along == 0 ? size_t{1} : size_t{0}, along == 2 ? size_t{1} : size_t{2}, along};
  const std::array<size_t, 3> stride{1, static_cast<size_t>(cells.blocks[0]),
                                     static_cast<size_t>(cells.blocks[0]) *
                                         static_cast<size_t>(cells.blocks[1])};
  for (size_t n = 0; n < 3; ++n) blocks_[n] = cells.blocks[axes_[n]], stride_[n] = stride[axes_[n]];
  for (size_t bit = 0; bit < 64; ++bit) layer_[bit >> (2 * along) & 3] |= uint64_t{1} << bit;
  const double plane = slice.lattice.plane_distance();
  const double ahead = view.ez[along];
  slope_u_ = view.ez[axes_[0]] / ahead, slope_v_ = view.ez[axes_[1]] / ahead;
  per_plane_ = plane / ahead;
  direction_ = ahead > 0 ? 1 : -1;
  make_masks(slope_u_, axes_[0], mask_u_);
  make_masks(slope_v_, axes_[1], mask_v_);
  find_slabs(slice, view, context);
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
  const size_t count = static_cast<size_t>(squares_) * static_cast<size_t>(rows);
  const size_t words = count * static_cast<size_t>(words_);
  memory_ = Reservation(context.memory, words * sizeof(uint64_t) + count, "the way of rays");
  any_.assign(count, 0);
  slabs_.assign(words, 0);
  constexpr double margin = 0.01; // pixels
  double reach_x = margin, reach_y = margin;
  for (size_t a = 0; a < 3; ++a)
    reach_x += half * std::fabs(view.gx[a]), reach_y += half * std::fabs(view.gy[a]);
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
      const double x0 = dot(view.gx, p - view.eye), y0 = dot(view.gy, p - view.eye);
      const int order = along(z);
      const auto word = static_cast<size_t>(order / 64);
      const uint64_t* const row = &cells_.bits[at(0, y, z)];
      for (int x = 0; x < blocks_[0]; ++x) {
        if (row[static_cast<size_t>(x) * stride_[0]] == 0) continue;
        const double i = x0 + x * step * view.gx[u], j = y0 + x * step * view.gy[u];
        const int i0 = std::max(square(i - reach_x, squares_), 0),
                  i1 = std::min(square(i + reach_x, squares_), squares_ - 1),
                  j0 = std::max(square(j - reach_y, rows), 0),
                  j1 = std::min(square(j + reach_y, rows), rows - 1);
        for (int t = j0; t <= j1; ++t)
          for (int s = i0; s <= i1; ++s) {
            const size_t n = static_cast<size_t>(t) * static_cast<size_t>(squares_) + static_cast<size_t>(s);
            any_[n] = 1;
            slabs_[n * static_cast<size_t>(words_) + word] |= uint64_t{1} << (order % 64);
          }
      }
    }
  }
}

bool RayWay::begin(int i, int j, Ray& ray) const {
  ray.at = view_.sample(i, j, 0);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double enter = -infinity, leave = infinity;
  for (size_t a = 0; a < 3; ++a) {
    const double before = box_.begin[a] - ray.at[a], behind = box_.end[a] - ray.at[a];
    if (view_.ez[a] == 0) {
      if (before > 0 || behind < 0) return false;
      continue;
    }
    const double k0 = before * per_unit_[a], k1 = behind * per_unit_[a];
    enter = std::max(enter, std::min(k0, k1)), leave = std::min(leave, std::max(k0, k1));
  }
  if (!(enter < leave)) return false;
  ray.enter = enter, ray.leave = leave;
  ray.u = ray.at[axes_[0]] * planes_, ray.v = ray.at[axes_[1]] * planes_, ray.w = ray.at[axes_[2]] * planes_;
  ray.slabs = &slabs_[square_at(i, j) * static_cast<size_t>(words_)];
  const double per_sheet = 1 / per_plane_;
  const auto slab = [&](double k) {
    constexpr double per_block = 1.0 / block_edge;
    return along(std::clamp(floor_of((ray.w + k * per_sheet) * per_block), 0, blocks_[2] - 1));
  };
  // A ray may begin at the face between two slabs: both are looked at.
  const double margin = 1e-6 * std::fabs(per_plane_);
  ray.slab = slab(enter - margin), ray.end = slab(leave + margin) + 1;
  return true;
}

uint32_t RayWay::advance(Ray& ray) const {
  const Int3& n = blocks_;
  constexpr double per_block = 1.0 / block_edge, margin = 1e-6;
  const double least_u = std::min(0.0, slope_u_) - margin + ray.u * per_block,
               least_v = std::min(0.0, slope_v_) - margin + ray.v * per_block;
  const double reach_u = std::fabs(slope_u_) + 2 * margin, reach_v = std::fabs(slope_v_) + 2 * margin;
  const double w = ray.w * per_block;
  for (; ray.slab < ray.end; ++ray.slab) {
    const uint64_t next = ray.slabs[ray.slab / 64] >> (ray.slab % 64);
    if ((next & 1) == 0) {
      const int free = next == 0 ? 64 - ray.slab % 64 : std::countr_zero(next);
      ray.slab += free - 1;
      continue;
    }
    const int slab = along(ray.slab);
    const double past = slab - w;
    const double u = least_u + slope_u_ * past, v = least_v + slope_v_ * past; // blocks
    const int u0 = std::max(floor_of(u), 0), u1 = std::min(floor_of(u + reach_u), n[0] - 1),
              v0 = std::max(floor_of(v), 0), v1 = std::min(floor_of(v + reach_v), n[1] - 1);
    uint64_t found = 0;
    for (int bv = v0; bv <= v1; ++bv)
      for (int bu = u0; bu <= u1; ++bu) {
        const uint64_t word = cells_.bits[at(bu, bv, slab)];
        if (word == 0) continue;
        const auto place_u = static_cast<int>((u - bu + 1) * (block_edge * parts)),
                   place_v = static_cast<int>((v - bv + 1) * (block_edge * parts));
        constexpr int most = 2 * block_edge * parts - 1;
        found |= word & mask_u_[static_cast<size_t>(std::clamp(place_u, 0, most))] &
                 mask_v_[static_cast<size_t>(std::clamp(place_v, 0, most))];
      }
    if (found == 0) continue;
    uint32_t layers = 0;
    for (uint32_t l = 0; l < block_edge; ++l) layers |= (found & layer_[l]) != 0 ? 1u << l : 0;
    return layers;
  }
  return 0;
}

} // namespace bccsplat
