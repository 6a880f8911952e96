// SPDX-License-Identifier: Apache-2.0
// A ray passes a slab of blocks within at most two blocks along either axis across. Which cells of a block it
// may pass follows from where it is at the slab's one side: masks by that place, one for each axis across, of
// all rays that are there in an eighth of a cell. The blocks' pictures tell which slabs a square of pixels
// may need at all.
#include "tests/bench/rays/ray_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace bccsplat::bench {
namespace {

// The whole number below x, which is no further than this below 0.
constexpr int below_zero = 1 << 16;
int floor_of(double x) { return static_cast<int>(x + below_zero) - below_zero; }

} // namespace

BlockBits make_block_bits(const CellRanges& ranges, size_t along, double target, bool all) {
  BlockBits b;
  b.axes = {along == 0 ? size_t{1} : size_t{0}, along == 2 ? size_t{1} : size_t{2}, along};
  for (size_t a = 0; a < 3; ++a) b.blocks[a] = ranges.blocks[b.axes[a]];
  b.bits.assign(ranges.of_block.size(), 0);
  std::array<size_t, 3> shift; // of a cell's bit by its x, y, z
  for (size_t a = 0; a < 3; ++a) shift[b.axes[a]] = size_t{1} << (2 * a);
  Int3 n;
  for (n[2] = 0; n[2] < ranges.blocks[2]; ++n[2])
    for (n[1] = 0; n[1] < ranges.blocks[1]; ++n[1])
      for (n[0] = 0; n[0] < ranges.blocks[0]; ++n[0]) {
        uint64_t& word = b.bits[b.at(n[b.axes[0]], n[b.axes[1]], n[b.axes[2]])];
        const int32_t slot =
            ranges.of_block[static_cast<size_t>((n[2] * ranges.blocks[1] + n[1]) * ranges.blocks[0] + n[0])];
        if (all) word = ~uint64_t{0};
        if (all || slot < 0) continue;
        const BlockRanges& r = ranges.ranges[static_cast<size_t>(slot)];
        const double at = (target - static_cast<double>(r.low)) / static_cast<double>(r.scale);
        if (!(at >= -0.01 && at <= 254.02)) continue;
        const auto below = static_cast<uint8_t>(std::clamp(std::floor(at + 0.001), 0.0, 254.0)),
                   above = static_cast<uint8_t>(std::clamp(std::ceil(at - 0.001), 0.0, 254.0));
        std::array<uint8_t, 64> may;
        bool any = false;
        for (size_t c = 0; c < 64; ++c) {
          may[c] = static_cast<uint8_t>((r.from[c] <= below) & (r.to[c] >= above));
          any |= may[c] != 0;
        }
        if (!any) continue;
        for (size_t c = 0; c < 64; ++c)
          word |= uint64_t{may[c]} << ((c & 3) * shift[0] + (c >> 2 & 3) * shift[1] + (c >> 4) * shift[2]);
      }
  return b;
}

BlockWay::BlockWay(const BlockBits& bits, const Slice& slice, const SheetView& view) : bits_(bits) {
  const double plane = slice.lattice.plane_distance();
  const double ahead = view.ez[bits.axes[2]];
  slope_u_ = view.ez[bits.axes[0]] / ahead, slope_v_ = view.ez[bits.axes[1]] / ahead;
  per_plane_ = plane / ahead;
  direction_ = ahead > 0 ? 1 : -1;
  make_masks(slope_u_, 1, mask_u_);
  make_masks(slope_v_, 4, mask_v_);
  find_slabs(slice, view);
}

// Entry n: rays whose smallest coordinate in the slab is between n and n + 1 parts, less a block.
void BlockWay::make_masks(double slope, int shift, Masks& masks) const {
  constexpr double margin = 1e-6;
  const double s = std::fabs(slope);
  for (size_t n = 0; n < masks.size(); ++n) {
    masks[n] = 0;
    const double from = static_cast<double>(n) / parts - block_edge;
    for (int layer = 0; layer < block_edge; ++layer) {
      const int step = slope >= 0 ? layer : block_edge - 1 - layer;
      const int first = static_cast<int>(std::floor(from + s * step - margin)),
                last = static_cast<int>(std::floor(from + 1.0 / parts + s * (step + 1) + margin));
      for (int c = std::max(first, 0); c <= std::min(last, block_edge - 1); ++c)
        for (int other = 0; other < block_edge; ++other)
          masks[n] |= uint64_t{1} << (layer * 16 + c * shift + other * (5 - shift));
    }
  }
}

// Of each square of pixels, the slabs that hold a block whose picture touches the square.
void BlockWay::find_slabs(const Slice& slice, const SheetView& view) {
  const double plane = slice.lattice.plane_distance(), half = 0.5 * block_edge * plane;
  squares_ = (view.width + square - 1) / square;
  const int rows = (view.height + square - 1) / square;
  words_ = (bits_.blocks[2] + 63) / 64;
  any_.assign(static_cast<size_t>(squares_ * rows), 0);
  slabs_.assign(any_.size() * static_cast<size_t>(words_), 0);
  constexpr double margin = 0.01; // pixels
  double reach_x = margin, reach_y = margin;
  for (size_t a = 0; a < 3; ++a)
    reach_x += half * std::fabs(view.gx[a]), reach_y += half * std::fabs(view.gy[a]);
  const auto [u, v, w] = bits_.axes;
  const double step = 2 * half;
  Vec3 p;
  for (int z = 0; z < bits_.blocks[2]; ++z)
    for (int y = 0; y < bits_.blocks[1]; ++y) {
      p[u] = half, p[v] = half + step * y, p[w] = half + step * z;
      const double x0 = dot(view.gx, p - view.eye), y0 = dot(view.gy, p - view.eye);
      const int order = along(z);
      const uint64_t* const row = &bits_.bits[bits_.at(0, y, z)];
      for (int x = 0; x < bits_.blocks[0]; ++x) {
        if (row[x] == 0) continue;
        const double i = x0 + x * step * view.gx[u], j = y0 + x * step * view.gy[u];
        constexpr double per_square = 1.0 / square;
        const int i0 = std::max(floor_of((i - reach_x) * per_square), 0),
                  i1 = std::min(floor_of((i + reach_x) * per_square), squares_ - 1),
                  j0 = std::max(floor_of((j - reach_y) * per_square), 0),
                  j1 = std::min(floor_of((j + reach_y) * per_square), rows - 1);
        for (int t = j0; t <= j1; ++t)
          for (int s = i0; s <= i1; ++s) {
            const auto at = static_cast<size_t>(t * squares_ + s);
            any_[at] = 1;
            slabs_[at * static_cast<size_t>(words_) + static_cast<size_t>(order / 64)] |= uint64_t{1}
                                                                                          << (order % 64);
          }
      }
    }
}

bool BlockWay::begin(const Slice& slice, const SheetView& view, int i, int j, Ray& ray) const {
  const auto [enter, leave] = ray_interval(slice, view, i, j);
  if (!(enter < leave)) return false;
  const double plane = slice.lattice.plane_distance();
  const Vec3 at = view.sample(i, j, 0);
  ray.u = at[bits_.axes[0]] / plane, ray.v = at[bits_.axes[1]] / plane, ray.w = at[bits_.axes[2]] / plane;
  ray.enter = enter, ray.leave = leave;
  ray.slabs = &slabs_[square_at(i, j) * static_cast<size_t>(words_)];
  const auto slab = [&](double k) {
    const double w = (ray.w + k / per_plane_) / block_edge;
    return along(std::clamp(floor_of(w), 0, bits_.blocks[2] - 1));
  };
  // A ray may begin at the face between two slabs: both are looked at.
  const double margin = 1e-6 * std::fabs(per_plane_);
  ray.slab = slab(enter - margin), ray.end = slab(leave + margin) + 1;
  return true;
}

uint32_t BlockWay::advance(Ray& ray) const {
  const Int3 n = bits_.blocks;
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
        const uint64_t word = bits_.bits[bits_.at(bu, bv, slab)];
        if (word == 0) continue;
        const auto place_u = static_cast<int>((u - bu + 1) * (block_edge * parts)),
                   place_v = static_cast<int>((v - bv + 1) * (block_edge * parts));
        constexpr int most = 2 * block_edge * parts - 1;
        found |= word & mask_u_[static_cast<size_t>(std::clamp(place_u, 0, most))] &
                 mask_v_[static_cast<size_t>(std::clamp(place_v, 0, most))];
      }
    if (found == 0) continue;
    uint32_t layers = 0;
    for (uint32_t l = 0; l < block_edge; ++l) layers |= (found >> (16 * l) & 0xffff) != 0 ? 1u << l : 0;
    return layers;
  }
  return 0;
}

} // namespace bccsplat::bench
