#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slice/prefilter.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "slice/prefilter.h"

#ifndef BCCSPLAT_PREFILTER_BLOCK
#define BCCSPLAT_PREFILTER_BLOCK
namespace bccsplat {

// A brick with a margin of one site: what a stage gathers.
inline constexpr int halo_edge = brick_edge + 2;
inline constexpr int halo_row = halo_edge;
inline constexpr int halo_plane = halo_edge * halo_edge;
inline constexpr int halo_sites = halo_edge * halo_edge * halo_edge;
// Rows of 16 read whole vectors one or two floats past a row's start; the last row of a block may run over.
inline constexpr int halo_padding = 16;
using HaloBlock = std::array<float, halo_sites + halo_padding>;

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// centre += w0 * block and neighbours += w1 * block, margins included.
void StageAdd(const float* block, float w0, float w1, float* centre, float* neighbours) {
  const hn::ScalableTag<float> d;
  const auto v0 = hn::Set(d, w0), v1 = hn::Set(d, w1);
  for (size_t i = 0; i < halo_sites; i += hn::Lanes(d)) { // the last vector ends in the padding
    const auto c = hn::Load(d, block + i);
    hn::Store(hn::MulAdd(v0, c, hn::Load(d, centre + i)), d, centre + i);
    hn::Store(hn::MulAdd(v1, c, hn::Load(d, neighbours + i)), d, neighbours + i);
  }
}

// out (16^3) = centre + the six neighbours of each site in `neighbours`
void StageSpatial(const float* centre, const float* neighbours, float* out) {
  const hn::CappedTag<float, brick_edge> d;
  for (int z = 0; z < brick_edge; ++z)
    for (int y = 0; y < brick_edge; ++y) {
      const int row = (z + 1) * halo_plane + (y + 1) * halo_row + 1;
      float* target = out + (z * brick_edge + y) * brick_edge;
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
        const float* c = neighbours + row + x;
        const auto along_x = hn::Add(hn::LoadU(d, c - 1), hn::LoadU(d, c + 1));
        const auto along_y = hn::Add(hn::LoadU(d, c - halo_row), hn::LoadU(d, c + halo_row));
        const auto along_z = hn::Add(hn::LoadU(d, c - halo_plane), hn::LoadU(d, c + halo_plane));
        const auto sum = hn::Add(hn::Add(along_x, along_y), along_z);
        hn::Store(hn::Add(hn::LoadU(d, centre + row + x), sum), d, target + x);
      }
    }
}

// out += weight * (sum of the 8 corners around each site); block holds the other coset, whose sites l + shift
// and l + shift + 1 of the margin-one block stand on either side of site l.
void StageCross(float weight, const float* block, int shift, float* pair_x, float* pair_y, float* out) {
  const hn::CappedTag<float, brick_edge> d;
  const auto w = hn::Set(d, weight);
  for (int z = 0; z < halo_edge; ++z) {
    for (int y = 0; y < halo_edge; ++y) {
      const float* row = block + z * halo_plane + y * halo_row + shift;
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d))
        hn::Store(hn::Add(hn::LoadU(d, row + x), hn::LoadU(d, row + x + 1)), d,
                  pair_x + y * brick_edge + static_cast<int>(x));
    }
    float* plane = pair_y + z * brick_rows;
    for (int y = 0; y < brick_edge; ++y)
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
        const float* p = pair_x + (y + shift) * brick_edge + static_cast<int>(x);
        hn::Store(hn::Add(hn::Load(d, p), hn::Load(d, p + brick_edge)), d,
                  plane + y * brick_edge + static_cast<int>(x));
      }
  }
  for (int z = 0; z < brick_edge; ++z) {
    const float* low = pair_y + (z + shift) * brick_rows;
    float* target = out + z * brick_rows;
    for (size_t i = 0; i < brick_rows; i += hn::Lanes(d)) {
      const auto corners = hn::Add(hn::Load(d, low + i), hn::Load(d, low + brick_rows + i));
      hn::Store(hn::MulAdd(w, corners, hn::Load(d, target + i)), d, target + i);
    }
  }
}

void AddBlock(const float* source, float* target, size_t count) {
  const hn::ScalableTag<float> d;
  size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d))
    hn::StoreU(hn::Add(hn::LoadU(d, target + i), hn::LoadU(d, source + i)), d, target + i);
  for (; i < count; ++i) target[i] += source[i];
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace bccsplat {
HWY_EXPORT(StageAdd);
HWY_EXPORT(StageSpatial);
HWY_EXPORT(StageCross);
HWY_EXPORT(AddBlock);

namespace {

struct Work {
  alignas(64) HaloBlock block{}, other{}, centre{}, neighbours{};
  alignas(64) std::array<float, halo_edge * brick_edge> pair_x{};
  alignas(64) std::array<float, halo_edge * brick_rows> pair_y{};
};

// Sites beyond the coset's dims in an edge brick are air.
void clear_beyond(const BrickLayer& layer, const Int3& b, Brick& brick) {
  Int3 n;
  for (size_t a = 0; a < 3; ++a) n[a] = std::min(brick_edge, layer.dims()[a] - b[a] * brick_edge);
  if (n == Int3{brick_edge, brick_edge, brick_edge}) return;
  for (int z = 0; z < brick_edge; ++z)
    for (int y = 0; y < brick_edge; ++y) {
      const int keep = z < n[2] && y < n[1] ? n[0] : 0;
      float* row = brick.value.data() + (z * brick_edge + y) * brick_edge;
      std::fill(row + keep, row + brick_edge, 0.0f);
    }
}

std::shared_ptr<Brick> stage_brick(const PrefilterStage& stage, const StageInput& in, size_t slot, Work& w) {
  const Int3 b = in.previous.own->slot_position(slot);
  const auto gather = [&](const BrickLayer* layer, HaloBlock& block) {
    return layer && layer->gather(b[0], b[1], b[2], 1, std::span(block).first(halo_sites));
  };
  bool any = false;
  const auto add = [&](const BrickLayer* layer, double w0, double w1) {
    if ((w0 == 0 && w1 == 0) || !gather(layer, w.block)) return;
    if (!any) w.centre.fill(0), w.neighbours.fill(0);
    any = true;
    HWY_DYNAMIC_DISPATCH(StageAdd)
    (w.block.data(), static_cast<float>(w0), static_cast<float>(w1), w.centre.data(), w.neighbours.data());
  };
  add(in.previous.own, stage.self, stage.spatial);
  add(in.previous.before, stage.temporal, stage.mixed);
  add(in.previous.after, stage.temporal, stage.mixed);
  add(in.samples.own, stage.source, stage.source_spatial);
  add(in.samples.before, stage.source_temporal, stage.source_mixed);
  add(in.samples.after, stage.source_temporal, stage.source_mixed);
  std::shared_ptr<Brick> out;
  if (any) {
    out = std::make_shared<Brick>();
    HWY_DYNAMIC_DISPATCH(StageSpatial)(w.centre.data(), w.neighbours.data(), out->value.data());
  }
  if (stage.cross != 0) {
    bool cross = gather(in.cross_before, w.block);
    if (cross) {
      if (gather(in.cross_after, w.other))
        HWY_DYNAMIC_DISPATCH(AddBlock)(w.other.data(), w.block.data(), halo_sites);
    } else {
      cross = gather(in.cross_after, w.block);
    }
    // Site l of coset 0 lies between l-1 and l of coset 1; of coset 1 between l and l+1 of coset 0. The block
    // starts at -1.
    if (cross) {
      if (!out) out = std::make_shared<Brick>();
      HWY_DYNAMIC_DISPATCH(StageCross)
      (static_cast<float>(stage.cross), w.block.data(), in.previous.own->coset(), w.pair_x.data(),
       w.pair_y.data(), out->value.data());
    }
  }
  if (out) clear_beyond(*in.previous.own, b, *out);
  return out;
}

} // namespace

BrickLayer apply_stage(const PrefilterStage& stage, const StageInput& input, const BrickBox& region,
                       const Context& context) {
  BrickLayer result(input.previous.own->lattice(), input.previous.own->coset());
  // One task per row of bricks along x: a few hundred microseconds each.
  const auto row = static_cast<size_t>(result.brick_dims()[0]);
  context.tasks.parallel_for(result.brick_slots() / row, [&](uint64_t r) {
    context.progress.check();
    const auto work = std::make_unique<Work>();
    for (size_t slot = r * row; slot < (r + 1) * row; ++slot)
      if (region.contains(result.slot_position(slot)))
        result.set(slot, stage_brick(stage, input, slot, *work));
  });
  return result;
}

BrickLayer finish_coefficients(const BrickLayer& coefficients, const BrickLayer& samples, float prune,
                               const Context& context) {
  BrickLayer result(coefficients.lattice(), coefficients.coset());
  context.tasks.parallel_for(result.brick_slots(), [&](uint64_t slot) {
    const Brick* c = coefficients.brick(slot);
    const Brick* s = samples.brick(slot);
    const bool holes = s && s->hole;
    if (!c && !holes) return;
    auto brick = std::make_shared<Brick>();
    if (c) brick->value = c->value;
    const int count = brick->keep_above(prune);
    if (holes) brick->hole = std::make_unique<BrickMask>(*s->hole);
    if (count > 0 || holes) result.set(slot, std::move(brick));
  });
  return result;
}

} // namespace bccsplat
#endif
