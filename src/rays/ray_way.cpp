// SPDX-License-Identifier: Apache-2.0
// A ray passes a slab of blocks within a few blocks along either axis across, two where it is no more than 45
// degrees from the axis of the slabs. Which cells of a block it may pass follows from where it is at the
// slab's one side: masks by that place, one for each axis across, of all rays that are there in an eighth of
// a cell. In perspective slopes differ from pixel to pixel, and masks are for all slopes of a short range.
// The blocks' pictures tell which slabs a square of pixels may need at all.
#include "rays/ray_way.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace bccsplat {
namespace {

constexpr double slope_pitch = 1.0 / 64;
constexpr double slope_rounding = 1e-9;

// The whole number below x, which is no further than this below 0.
constexpr int below_zero = 1 << 16;
int floor_of(double x) { return static_cast<int>(x + below_zero) - below_zero; }

// half: of the boxes' edges.
class BlockPictures {
 public:
  // Where voxels are no cubes rays are aslant to the sheets, and a column drifts with depth.
  BlockPictures(const SheetView& view, const Vec3& half)
      : perspective_(view.perspective), eye_(view.eye), depth_((1 / view.step) * view.normal),
        x_(view.gx - dot(view.gx, view.ez) * depth_), y_(view.gy - dot(view.gy, view.ez) * depth_),
        half_(half), reach_{reach(x_), reach(y_)}, reach_depth_(reach(depth_)) {}

  [[nodiscard]] PixelBox find(const Vec3& middle) const {
    const Vec3 p = middle - eye_;
    double i = dot(x_, p), j = dot(y_, p);
    if (!perspective_) return {i - reach_[0], i + reach_[0], j - reach_[1], j + reach_[1]};
    // (x.(p + d)) / (depth.(p + d)) - i = (x.d - i depth.d) / (depth.(p + d))
    const double z = dot(depth_, p), nearest = z - reach_depth_;
    constexpr double far = std::numeric_limits<double>::infinity();
    if (z + reach_depth_ < 0) return {far, -far, far, -far};
    if (!(nearest > 0)) return {-far, far, -far, far};
    i /= z, j /= z;
    const double di = margin + reach(x_ - i * depth_) / nearest,
                 dj = margin + reach(y_ - j * depth_) / nearest;
    return {i - di, i + di, j - dj, j + dj};
  }

 private:
  static constexpr double margin = 0.01; // pixels
  [[nodiscard]] double reach(const Vec3& v) const {
    return half_[0] * std::fabs(v[0]) + half_[1] * std::fabs(v[1]) + half_[2] * std::fabs(v[2]) +
           (perspective_ ? 0 : margin);
  }
  bool perspective_;
  Vec3 eye_, depth_, x_, y_, half_;
  std::array<double, 2> reach_;
  double reach_depth_;
};

} // namespace

RayWay::RayWay(const SurfaceCells& cells, const Slice& slice, const SheetView& view, const RayAxis& axis,
               const Context& context, CellMarker* marker)
    : cells_(cells), marker_(marker), view_(view), box_(drawn_box(slice)),
      plane_(slice.lattice.plane_distance()), axes_{axis.across[0].axis, axis.across[1].axis, axis.along},
      direction_(axis.direction) {
  const size_t along = axis.along;
  const std::array<size_t, 3> stride{1, static_cast<size_t>(cells.blocks[0]),
                                     static_cast<size_t>(cells.blocks[0]) * cells.blocks[1]};
  for (size_t n = 0; n < 3; ++n) blocks_[n] = cells.blocks[axes_[n]], stride_[n] = stride[axes_[n]];
  for (size_t bit = 0; bit < 64; ++bit) layer_[bit >> (2 * along) & 3] |= uint64_t{1} << bit;
  most_sheets_ = static_cast<size_t>(block_edge * plane_ / axis.least) + 3;
  make_masks(axis.across[0], context, masks_u_);
  make_masks(axis.across[1], context, masks_v_);
  make_runs();
  find_slabs(view, context);
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

// A cell is passed where the smallest coordinate, more by the way to its layer, is in it.
void RayWay::make_masks(const RayAxis::Across& across, const Context& context, Masks& masks) {
  constexpr double margin = 1e-6; // cells
  constexpr int parts = PassMasks::parts;
  // The bits of the cells with this layer and this place across.
  std::array<std::array<uint64_t, block_edge>, block_edge> cells{};
  for (size_t bit = 0; bit < 64; ++bit)
    cells[bit >> (2 * axes_[2]) & 3][bit >> (2 * across.axis) & 3] |= uint64_t{1} << bit;
  const double range = across.high - across.low, pitch = std::min(slope_pitch, range);
  const size_t count = pitch > 0 ? static_cast<size_t>(range / pitch) + 1 : 1;
  masks_memory_.emplace_back(context.memory, count * sizeof(PassMasks), "the way of rays");
  masks.low = across.low, masks.per_pitch = pitch > 0 ? 1 / pitch : 0;
  masks.of_pitch.resize(count);
  for (size_t q = 0; q < count; ++q) {
    PassMasks& to = masks.of_pitch[q];
    const double low = across.low + static_cast<double>(q) * pitch - slope_rounding,
                 high = std::min(low + pitch + across.of_piece, across.high) + slope_rounding;
    const double up = std::max(high, 0.0), down = std::max(-low, 0.0);
    const double least_up = std::max(low, 0.0), least_down = std::max(-high, 0.0);
    to.across = std::max(2, 1 + static_cast<int>(std::ceil(std::max(up, down) - 2 * slope_rounding)));
    for (size_t n = 0; n < to.across * PassMasks::places; ++n) {
      const double from = static_cast<double>(n) / parts - (to.across - 1) * block_edge;
      for (int layer = 0; layer < block_edge; ++layer) {
        const int behind = block_edge - 1 - layer;
        const double least = least_up * layer + least_down * behind,
                     most = std::max(up * (layer + 1), down * (behind + 1));
        const int first = std::max(floor_of(from + least - margin), 0),
                  last = std::min(floor_of(from + 1.0 / parts + most + margin), block_edge - 1);
        for (int cell = first; cell <= last; ++cell) to.words[n] |= cells[layer][cell];
      }
    }
  }
}

const PassMasks* RayWay::Masks::of(const PieceRays::Doubles& slope) const {
  constexpr size_t edge = piece_edge;
  const double least = std::min(std::min(slope[0], slope[edge - 1]),
                                std::min(slope[piece_rays - edge], slope[piece_rays - 1]));
  const auto n = static_cast<size_t>(std::max((least - low) * per_pitch, 0.0));
  return &of_pitch[std::min(n, of_pitch.size() - 1)];
}

// Finds for each square of pixels the slabs with a block whose picture touches the square.
void RayWay::find_slabs(const SheetView& view, const Context& context) {
  constexpr int most_squares = 512; // along either side
  while (std::max(view.width, view.height) >> shift_ >= most_squares) ++shift_;
  const double step = block_edge * plane_;
  squares_ = ((view.width - 1) >> shift_) + 1;
  rows_ = ((view.height - 1) >> shift_) + 1;
  words_ = (blocks_[2] + 63) / 64;
  const size_t count = static_cast<size_t>(squares_) * rows_;
  const size_t words = count * words_;
  memory_ = Reservation(context.memory, words * sizeof(uint64_t) + count, "the way of rays");
  any_.assign(count, 0);
  slabs_.assign(words, 0);
  const BlockPictures pictures(view, {step / 2, step / 2, step / 2});
  const auto [u, v, w] = axes_;
  Vec3 p;
  for (int z = 0; z < blocks_[2]; ++z) {
    context.progress.check();
    for (int y = 0; y < blocks_[1]; ++y) {
      const uint64_t* const row = &cells_.bits[at(0, y, z)];
      for (int x = 0; x < blocks_[0]; ++x) {
        if (row[static_cast<size_t>(x) * stride_[0]] == 0) continue;
        p[u] = step * (x + 0.5), p[v] = step * (y + 0.5), p[w] = step * (z + 0.5);
        add_slabs(pictures.find(p), z, z);
      }
    }
  }
  if (marker_) add_waiting(view, context);
}

// Adds the slabs of stretches that are yet to be marked: any of their cells may hold the value.
void RayWay::add_waiting(const SheetView& view, const Context& context) {
  const std::array<int, 3> edge{stretch_blocks, column_blocks, column_blocks};
  const double step = block_edge * plane_;
  Vec3 size;
  for (size_t a = 0; a < 3; ++a) size[a] = step * edge[a];
  const BlockPictures pictures(view, 0.5 * size);
  const size_t w = axes_[2];
  Int3 n;
  for (n[2] = 0; n[2] < cells_.stretches[2]; ++n[2]) {
    context.progress.check();
    for (n[1] = 0; n[1] < cells_.stretches[1]; ++n[1])
      for (n[0] = 0; n[0] < cells_.stretches[0]; ++n[0]) {
        if (cells_.state[cells_.stretch_at(n)] != SurfaceCells::waiting) continue;
        const Vec3 middle{size[0] * (n[0] + 0.5), size[1] * (n[1] + 0.5), size[2] * (n[2] + 0.5)};
        const int first = n[w] * edge[w];
        add_slabs(pictures.find(middle), first, std::min(first + edge[w], blocks_[2]) - 1);
      }
  }
}

void RayWay::add_slabs(const PixelBox& picture, int first, int last) {
  const double per_square = 1.0 / (1 << shift_);
  // The number of a square, from the one before the picture to the one behind it.
  const auto square = [&](double pixel, int squares) {
    return floor_of(std::clamp(pixel * per_square, -1.0, static_cast<double>(squares)));
  };
  const int i0 = std::max(square(picture.i0, squares_), 0),
            i1 = std::min(square(picture.i1, squares_), squares_ - 1),
            j0 = std::max(square(picture.j0, rows_), 0), j1 = std::min(square(picture.j1, rows_), rows_ - 1);
  for (int t = j0; t <= j1; ++t)
    for (int s = i0; s <= i1; ++s) {
      const size_t n = static_cast<size_t>(t) * squares_ + s;
      any_[n] = 1;
      for (int slab = first; slab <= last; ++slab) {
        const int order = along(slab);
        slabs_[n * words_ + order / 64] |= uint64_t{1} << (order % 64);
      }
    }
}

uint64_t RayWay::find_rays(int i, int j, PieceWay& piece) const {
  const double scale = view_.scale(0);
  const Vec3 turn_i = view_.perspective ? view_.ex : Vec3{}, turn_j = view_.perspective ? view_.ey : Vec3{};
  const uint64_t meet = bccsplat::find_rays(
      {view_.sample(i, j, 0), scale * view_.ex, scale * view_.ey, view_.ray(i, j), turn_i, turn_j,
       view_.perspective ? -view_.depth : -std::numeric_limits<double>::infinity(), box_.begin, box_.end,
       axes_, plane_},
      piece.rays);
  piece.u = masks_u_.of(piece.rays.u.slope), piece.v = masks_v_.of(piece.rays.v.slope);
  return meet;
}

// The blocks along an axis across that the rays of a piece pass in a slab, by those of its corners: further
// on along the ray is further on along the axis, or further back, for all.
std::array<int, 2> RayWay::blocks_across(const PieceRays::Across& across, size_t n, int place) const {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const size_t corner : {size_t{0}, size_t{piece_edge} - 1, piece_rays - piece_edge, piece_rays - 1}) {
    const double slope = across.slope[corner], low = across.low[corner] + slope * place;
    least = std::min(least, low), most = std::max(most, low + std::fabs(slope));
  }
  constexpr double margin = 4e-6;
  const double end = blocks_[n];
  return {static_cast<int>(std::clamp(std::floor(least - margin), 0.0, end)),
          static_cast<int>(std::clamp(std::floor(most + margin) + 1, 0.0, end))};
}

uint64_t RayWay::find_layers(const PieceWay& piece, int slab, std::span<uint64_t, piece_rays> layers) const {
  const int place = along(slab);
  SlabArgs args{&cells_.bits[at(0, 0, place)],
                place,
                {0, blocks_[0], stride_[0], piece.u},
                {0, blocks_[1], stride_[1], piece.v},
                layer_};
  if (marker_) {
    const auto u = blocks_across(piece.rays.u, 0, place), v = blocks_across(piece.rays.v, 1, place);
    if (u[0] >= u[1] || v[0] >= v[1]) return 0;
    Int3 begin, end;
    begin[axes_[0]] = args.u.begin = u[0], end[axes_[0]] = args.u.end = u[1];
    begin[axes_[1]] = args.v.begin = v[0], end[axes_[1]] = args.v.end = v[1];
    begin[axes_[2]] = place, end[axes_[2]] = place + 1;
    if (!marker_->need(begin, end)) return 0;
  }
  return bccsplat::find_layers(args, piece.rays, layers);
}

} // namespace bccsplat
