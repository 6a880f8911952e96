// Applies one prefilter stage to a layer: sums of neighbours plane by plane within a brick, bricks in
// parallel. Products are rounded before they are added, so that every target computes the same coefficients.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "field/coefficients/prefilter.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <hwy/cache_control.h>

#include <bit>
#include <cmath>

#include "field/coefficients/prefilter.h"
#include "field/coefficients/stage_block.h"

#ifndef BCCSPLAT_PREFILTER_PLANES
#define BCCSPLAT_PREFILTER_PLANES
namespace bccsplat {

// Planes of a brick with a margin of one site. Site x of a row lies at row_start + x, so that rows of 16
// are aligned; the site after the last one lies in the next row's margin.
inline constexpr int plane_row = 32, row_start = 16;
inline constexpr int plane_rows = brick_edge + 2;
struct StagePlanes {
  alignas(64) std::array<std::array<float, plane_row * plane_rows + row_start>, 3> neighbours;
  alignas(64) std::array<float, 2 * plane_row> cross;                      // a row
  alignas(64) std::array<std::array<float, brick_edge>, plane_rows> pairs; // sums of 2 along x
  alignas(64) std::array<std::array<float, brick_rows>, 3> corners;        // sums of 4 in a plane
};

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Line = hn::CappedTag<float, brick_edge>;

int RowOffset(int y, int z) { return (z * brick_edge + y) * brick_edge; }

// to = sum over terms of their neighbours' weight times a row of 16.
template<class RowOf> HWY_INLINE void NeighbourRow(const StageBlock& b, const RowOf& row_of, float* to) {
  const Line d;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    auto sum = hn::Zero(d);
    for (int t = 0; t < b.neighbour_terms; ++t) {
      const StageTerm& term = b.term[static_cast<size_t>(t)];
      sum = hn::Add(hn::Mul(hn::Set(d, term.neighbours), hn::Load(d, row_of(term) + x)), sum);
    }
    hn::Store(sum, d, to + x);
  }
}

// The values whose six neighbours are summed, in plane z = -1 .. width of the brick.
void NeighbourPlane(const StageBlock& b, int z, float* plane) {
  const auto row = [&](int y) { return plane + (y + 1) * plane_row + row_start; };
  if (z < 0 || z == b.width[2]) {
    const int at = z < 0 ? b.low_site[2] : b.high_site[2];
    for (int y = 0; y < b.width[1]; ++y)
      NeighbourRow(
          b, [&](const StageTerm& t) { return (z < 0 ? t.low[2] : t.high[2]) + RowOffset(y, at); }, row(y));
    return;
  }
  NeighbourRow(
      b, [&](const StageTerm& t) { return t.low[1] + RowOffset(b.low_site[1], z); }, row(-1));
  NeighbourRow(
      b, [&](const StageTerm& t) { return t.high[1] + RowOffset(b.high_site[1], z); }, row(b.width[1]));
  for (int y = 0; y < b.width[1]; ++y) {
    const int at = RowOffset(y, z);
    float* to = row(y);
    NeighbourRow(
        b, [&](const StageTerm& t) { return t.own + at; }, to);
    float low = 0, high = 0;
    for (int t = 0; t < b.neighbour_terms; ++t) {
      const StageTerm& term = b.term[static_cast<size_t>(t)];
      low += term.neighbours * term.low[0][at + b.low_site[0]];
      high += term.neighbours * term.high[0][at + b.high_site[0]];
    }
    to[-1] = low, to[b.width[0]] = high;
  }
}

// Sums of the 4 corners around each site within plane i + shift of what StageCross sums.
void CornerPlane(const StageBlock& b, int i, StagePlanes& planes) {
  const StageCross& cross = b.cross;
  const Line d;
  const auto iz = static_cast<size_t>(i);
  float* corners = planes.corners[iz % 3].data();
  for (int j = 0; j < b.width[1] + cross.span; ++j) {
    const auto iy = static_cast<size_t>(j);
    const auto& first = cross.brick[0][cross.z.third[iz]][cross.y.third[iy]];
    const auto& second = cross.brick[1][cross.z.third[iz]][cross.y.third[iy]];
    const int at = RowOffset(cross.y.site[iy], cross.z.site[iz]);
    float* row = planes.cross.data() + row_start;
    for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
      auto sum = hn::Load(d, first[0] + at + x);
      if (cross.layers == 2) sum = hn::Add(sum, hn::Load(d, second[0] + at + x));
      hn::Store(sum, d, row + x);
    }
    for (int k = 0; k < cross.patches; ++k) {
      const StageCross::Patch& p = cross.patch[static_cast<size_t>(k)];
      const auto third = static_cast<size_t>(p.third);
      float sum = first[third][at + p.site];
      if (cross.layers == 2) sum += second[third][at + p.site];
      row[p.index + cross.shift] = sum;
    }
    const float *low = row + cross.shift, *high = low + cross.span;
    for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
      const auto pair = hn::Add(hn::LoadU(d, low + x), hn::LoadU(d, high + x));
      hn::Store(pair, d, planes.pairs[iy].data() + x);
      if (j < cross.span) continue;
      const auto below = hn::Load(d, planes.pairs[iy - static_cast<size_t>(cross.span)].data() + x);
      hn::Store(hn::Add(below, pair), d, corners + (j - cross.span) * brick_edge + x);
    }
  }
}

// A finished row: clears sites beyond the lattice and those that do not matter; returns the bits of the rest.
HWY_INLINE uint16_t FinishRow(float* row, int width, bool finish, float prune) {
  const Line d;
  const auto limit = hn::Set(d, finish ? prune : -1.0f);
  unsigned bits = 0;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const auto v = hn::Load(d, row + x);
    const auto inside = hn::FirstN(d, static_cast<size_t>(std::max(0, width - static_cast<int>(x))));
    const auto keep = hn::And(inside, hn::Gt(hn::Abs(v), limit));
    hn::Store(hn::IfThenElseZero(keep, v), d, row + x);
    std::array<uint8_t, 8> bytes{};
    hn::StoreMaskBits(d, keep, bytes.data());
    bits |= (bytes[0] | static_cast<unsigned>(bytes[1]) << 8) << x;
  }
  return static_cast<uint16_t>(bits);
}

// Asks for plane z of the bricks that the next block needs: they are far apart in memory.
void FetchPlane(const StageBlock& b, int z) {
  constexpr int line = 16; // floats
  for (int t = 0; t < b.terms; ++t)
    for (int i = 0; i < brick_rows; i += line)
      hwy::Prefetch(b.term[static_cast<size_t>(t)].own + z * brick_rows + i);
  for (int t = 0; t < b.cross.layers; ++t)
    for (int i = 0; i < brick_rows; i += line)
      hwy::Prefetch(b.cross.brick[static_cast<size_t>(t)][0][0][0] + z * brick_rows + i);
}

} // namespace

// Fills `out` and, to finish, its kept bits; returns whether any are set.
bool StageBrick(const StageBlock& b, const StageBlock& next, bool finish, float prune, StagePlanes& planes,
                Brick& out) {
  const Line d;
  const bool cross = b.cross.layers > 0;
  if (b.neighbour_terms > 0)
    NeighbourPlane(b, -1, planes.neighbours[0].data()), NeighbourPlane(b, 0, planes.neighbours[1].data());
  for (int i = 0; cross && i < b.cross.span; ++i) CornerPlane(b, i, planes);
  const auto w = hn::Set(d, b.cross.weight);
  unsigned any = 0;
  for (int z = 0; z < b.width[2]; ++z) {
    const auto k = static_cast<size_t>(z);
    FetchPlane(next, z);
    if (b.neighbour_terms > 0) NeighbourPlane(b, z + 1, planes.neighbours[(k + 2) % 3].data());
    if (cross) CornerPlane(b, z + b.cross.span, planes);
    const float* low = planes.corners[k % 3].data();
    const float* high = planes.corners[(k + static_cast<size_t>(b.cross.span)) % 3].data();
    const auto row_of = [&](size_t plane, int y) {
      return planes.neighbours[plane % 3].data() + (y + 1) * plane_row + row_start;
    };
    for (int y = 0; y < b.width[1]; ++y) {
      float* to = out.value.data() + RowOffset(y, z);
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (int t = 0; t < b.terms; ++t) {
          const StageTerm& term = b.term[static_cast<size_t>(t)];
          sum = hn::Add(hn::Mul(hn::Set(d, term.centre), hn::Load(d, term.own + RowOffset(y, z) + x)), sum);
        }
        if (b.neighbour_terms > 0) {
          const float* c = row_of(k + 1, y) + x;
          const auto along_x = hn::Add(hn::LoadU(d, c - 1), hn::LoadU(d, c + 1));
          const auto along_y = hn::Add(hn::Load(d, c - plane_row), hn::Load(d, c + plane_row));
          const auto along_z = hn::Add(hn::Load(d, row_of(k, y) + x), hn::Load(d, row_of(k + 2, y) + x));
          sum = hn::Add(sum, hn::Add(hn::Add(along_x, along_y), along_z));
        }
        if (cross) {
          const size_t i = static_cast<size_t>(y * brick_edge) + x;
          sum = hn::Add(hn::Mul(w, hn::Add(hn::Load(d, low + i), hn::Load(d, high + i))), sum);
        }
        hn::Store(sum, d, to + x);
      }
      const uint16_t bits = FinishRow(to, b.width[0], finish, prune);
      any |= bits;
      out.kept[static_cast<size_t>(z * brick_edge + y)] = finish ? bits : 0;
    }
  }
  return any != 0;
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <atomic>

#include "field/coefficients/inverse.h"

namespace bccsplat {
HWY_EXPORT(StageBrick);

namespace {

// Rows beyond the lattice, in an edge brick, are air.
void clear_rows_beyond(const Int3& width, Brick& brick) {
  for (int z = 0; z < brick_edge; ++z) {
    const int from = z < width[2] ? width[1] : 0;
    float* plane = brick.value.data() + z * brick_rows;
    std::fill(plane + from * brick_edge, plane + brick_rows, 0.0f);
    std::fill(brick.kept.begin() + z * brick_edge + from, brick.kept.begin() + (z + 1) * brick_edge,
              uint16_t{0});
  }
}

std::shared_ptr<Brick> stage_brick(const StageBlock& block, const StageBlock& next, const StageFinish* finish,
                                   size_t slot, StagePlanes& planes) {
  const Brick* sample = finish ? finish->samples->brick(slot) : nullptr;
  const bool holes = sample && sample->hole;
  if (block.empty() && !holes) return nullptr;
  auto out = std::make_shared_for_overwrite<Brick>();
  const bool kept = HWY_DYNAMIC_DISPATCH(StageBrick)(block, next, finish != nullptr,
                                                     finish ? finish->prune : 0, planes, *out);
  if (finish && !kept && !holes) return nullptr;
  if (block.width != Int3{brick_edge, brick_edge, brick_edge}) clear_rows_beyond(block.width, *out);
  if (holes) out->hole = std::make_unique<BrickMask>(*sample->hole);
  return out;
}

// Finds the bricks of a row along x, in `region`, that a stage may leave not empty: those beside which, or
// where, an input holds one. Mirror images lie no further away.
class Neighbourhood {
 public:
  Neighbourhood(const StageInput& input, const StageFinish* finish, const BrickBox& region,
                const BrickLayer& out)
      : region_(region), out_(out) {
    for (const BrickLayer* layer :
         {input.previous.own, input.previous.before, input.previous.after, input.samples.own,
          input.samples.before, input.samples.after, input.cross_before, input.cross_after,
          finish ? finish->samples : nullptr})
      if (layer && std::find(layers_.begin(), layers_.end(), layer) == layers_.end())
        layers_.push_back(layer);
  }

  // near: one byte per brick of the row. Returns whether any is set.
  bool find(size_t row, std::vector<uint8_t>& near) const {
    const Int3& n = out_.brick_dims();
    const auto y = static_cast<int>(row % static_cast<size_t>(n[1]));
    const auto z = static_cast<int>(row / static_cast<size_t>(n[1]));
    if (y < region_.begin[1] || y >= region_.end[1] || z < region_.begin[2] || z >= region_.end[2])
      return false;
    bool any = false;
    for (const BrickLayer* layer : layers_) {
      const Int3& m = layer->brick_dims(); // the other coset may have one brick less
      for (int k = std::max(z - 1, 0); k <= std::min(z + 1, m[2] - 1); ++k)
        for (int j = std::max(y - 1, 0); j <= std::min(y + 1, m[1] - 1); ++j) {
          const size_t first = layer->slot(0, j, k);
          if (layer->row_empty(first / layer->row_slots())) continue;
          if (!any) near.assign(static_cast<size_t>(n[0]), 0);
          any = true;
          for (int i = 0; i < m[0]; ++i) {
            if (!layer->brick(first + static_cast<size_t>(i))) continue;
            const int begin = std::max({i - 1, region_.begin[0], 0});
            const int end = std::min({i + 2, region_.end[0], n[0]});
            for (int x = begin; x < end; ++x) near[static_cast<size_t>(x)] = 1;
          }
        }
    }
    return any;
  }

 private:
  std::vector<const BrickLayer*> layers_;
  const BrickBox& region_;
  const BrickLayer& out_;
};

} // namespace

BrickLayer apply_stage(const PrefilterStage& stage, const StageInput& input, const StageFinish* finish,
                       const BrickBox& region, const Context& context) {
  if (stage.pole != 0) return apply_inverse(stage, *input.previous.own, finish, region, context);
  BrickLayer result(input.previous.own->lattice(), input.previous.own->coset());
  const Neighbourhood occupied(input, finish, region, result);
  // One task per row of bricks along x: a few dozen microseconds each where there is anything.
  const size_t row = result.row_slots();
  std::atomic<uint64_t> done{0};
  context.tasks.parallel_for(result.rows(), [&](uint64_t r) {
    context.progress.advance(done.fetch_add(1, std::memory_order_relaxed), result.rows());
    std::vector<uint8_t> near;
    if (!occupied.find(r, near)) return;
    const auto planes = std::make_unique_for_overwrite<StagePlanes>();
    std::vector<StageBlock> blocks; // and an empty one after the last
    std::vector<size_t> slots;
    for (size_t x = 0; x < row; ++x) {
      if (near[x] == 0) continue;
      slots.push_back(r * row + x);
      blocks.push_back(stage_block(stage, input, result.slot_position(slots.back())));
    }
    blocks.emplace_back();
    for (size_t i = 0; i < slots.size(); ++i)
      result.set(slots[i], stage_brick(blocks[i], blocks[i + 1], finish, slots[i], *planes));
  });
  return result;
}

} // namespace bccsplat
#endif
