// SPDX-License-Identifier: Apache-2.0
// Sums the layers in reach, then inverts one axis after the other: some bricks in a row with the sites in
// reach along the axis are copied, and shrink to the bricks factor by factor. Products are rounded before
// they are added, so that every target computes the same coefficients.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "field/coefficients/inverse.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "field/coefficients/inverse.h"
#include "field/footprint/dense_sites.h"

#ifndef BCCSPLAT_INVERSE_FACTOR
#define BCCSPLAT_INVERSE_FACTOR
namespace bccsplat {

// One factor: sites become `self` times themselves and `side` times those `stride` before and behind, along
// the middle one of three nested dimensions.
struct InverseFactor {
  float self = 1, side = 0;
  int stride = 1;
};
struct InverseLines {
  int outer = 1, pitch = 0, inner = 1; // sites from one outer line to the next, floats of a site
};

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// `length` sites of each line come out; they begin `stride` sites later. Whole vectors are written: into the
// line that follows, which comes later.
void ApplyFactor(const InverseFactor& f, const InverseLines& lines, int length, const float* from,
                 float* to) {
  const hn::ScalableTag<float> d;
  const auto self = hn::Set(d, f.self), side = hn::Set(d, f.side);
  const size_t shift = f.stride * lines.inner, pitch = lines.pitch * lines.inner,
               count = length * lines.inner;
  for (int o = 0; o < lines.outer; ++o, from += pitch, to += pitch)
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
      const auto sides = hn::Add(hn::LoadU(d, from + i), hn::LoadU(d, from + i + 2 * shift));
      hn::StoreU(hn::Add(hn::Mul(self, hn::LoadU(d, from + i + shift)), hn::Mul(side, sides)), d, to + i);
    }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(ApplyFactor);

namespace {

// Bricks that are copied at once, more than half a megabyte would leave the fast caches; floats that a vector
// may touch behind them.
constexpr int most_bricks = 8, beyond = 64;
using TwoCopies = std::array<std::vector<float>, 2>;

// 1 / (1 - p w) is the product of 1 + (p w)^(2^k): four factors reach 15 sites.
std::vector<InverseFactor> factors_of(const PrefilterStage& stage) {
  std::vector<InverseFactor> factors;
  double gain = std::cbrt(stage.self);
  for (int stride = 1; 2 * stride - 1 <= PrefilterStage::pole_reach; stride *= 2, gain = 1) {
    const double q = std::pow(stage.pole, stride);
    factors.push_back({static_cast<float>(gain * (1 + q * q)), static_cast<float>(gain * q), stride});
  }
  return factors;
}

// Sites beyond the lattice, in an edge brick, are air.
void clear_beyond(const Int3& dims, const Int3& brick, Brick& out) {
  Int3 width;
  for (size_t a = 0; a < 3; ++a) width[a] = std::min(brick_edge, dims[a] - brick[a] * brick_edge);
  if (width == Int3{brick_edge, brick_edge, brick_edge}) return;
  for (int s = 0; s < brick_sites; ++s)
    if (s % brick_edge >= width[0] || s / brick_edge % brick_edge >= width[1] || s / brick_rows >= width[2])
      out.value[s] = 0;
}

// Some bricks along an axis, from this one on.
struct BrickRun {
  size_t axis;
  Int3 first;
  int count;
};

// Filters the bricks along their axis; out: the first one, and how far apart they are. Nothing is made where
// nothing is in reach.
void filter_run(const std::vector<InverseFactor>& factors, const BrickLayer& from, const BrickRun& run,
                TwoCopies& copies, std::shared_ptr<Brick>* out, size_t apart) {
  SiteBox box{{}, {brick_edge, brick_edge, brick_edge}};
  for (size_t a = 0; a < 3; ++a) box.origin[a] = run.first[a] * brick_edge;
  int length = run.count * brick_edge + 2 * PrefilterStage::pole_reach;
  box.origin[run.axis] -= PrefilterStage::pole_reach, box.size[run.axis] = length;
  for (auto& copy : copies) copy.resize(std::max(copy.size(), size_t(length) * brick_rows + beyond));
  if (!gather_box(from, box, copies[0].data())) return;
  InverseLines lines{1, length, run.axis == 0 ? 1 : run.axis == 1 ? brick_edge : brick_rows};
  lines.outer = brick_rows / lines.inner;
  for (const InverseFactor& factor : factors) {
    length -= 2 * factor.stride;
    HWY_DYNAMIC_DISPATCH(ApplyFactor)(factor, lines, length, copies[0].data(), copies[1].data());
    std::swap(copies[0], copies[1]);
  }
  const size_t part = size_t{brick_edge} * lines.inner;
  for (Int3 brick = run.first; brick[run.axis] < run.first[run.axis] + run.count;
       ++brick[run.axis], out += apart) {
    *out = std::make_shared_for_overwrite<Brick>();
    const float* in = copies[0].data() + (brick[run.axis] - run.first[run.axis]) * part;
    for (int o = 0; o < lines.outer; ++o, in += size_t(lines.pitch) * lines.inner)
      std::copy_n(in, part, (*out)->value.data() + o * part);
    clear_beyond(from.dims(), brick, **out);
  }
}

// Returns whether the brick or a neighbour along the axis holds anything; mirror images lie no further away,
// and what a periodic axis has beyond its end is looked at.
bool near(const BrickLayer& from, size_t axis, Int3 brick) {
  const int at = brick[axis], bricks = from.brick_dims()[axis];
  if (from.lattice().periodic[axis]) { // whose last brick may be narrow
    for (int i = at - 2; i <= at + 2; ++i) {
      brick[axis] = ((i % bricks) + bricks) % bricks;
      if (from.brick(brick[0], brick[1], brick[2])) return true;
    }
    return false;
  }
  for (int i = std::max(at - 1, 0); i <= std::min(at + 1, bricks - 1); ++i) {
    brick[axis] = i;
    if (from.brick(brick[0], brick[1], brick[2])) return true;
  }
  return false;
}

// Returns the bricks by slot; null where nothing is.
std::vector<std::shared_ptr<Brick>> filter_along(const PrefilterStage& stage, const BrickLayer& from,
                                                 size_t axis, const BrickBox& region,
                                                 const Context& context) {
  const std::vector<InverseFactor> factors = factors_of(stage);
  std::vector<std::shared_ptr<Brick>> made(from.brick_slots());
  Int3 across = from.brick_dims(); // lines of bricks along the axis
  const int bricks = std::exchange(across[axis], 1);
  const Int3 next{axis == 0, axis == 1, axis == 2};
  const size_t apart = bricks > 1 ? from.slot(next[0], next[1], next[2]) : 0;
  context.tasks.parallel_for(size_t(across[0]) * across[1] * across[2], [&](uint64_t line) {
    context.progress.check();
    TwoCopies copies;
    const auto n = static_cast<int32_t>(line);
    BrickRun run{axis, {n % across[0], n / across[0] % across[1], n / across[0] / across[1]}, 0};
    const auto end = [&] {
      if (run.count > 0)
        filter_run(factors, from, run, copies, &made[from.slot(run.first[0], run.first[1], run.first[2])],
                   apart);
      run.count = 0;
    };
    for (Int3 brick = run.first; brick[axis] < bricks; ++brick[axis]) {
      if (run.count == most_bricks) end();
      if (!region.contains(brick) || !near(from, axis, brick)) {
        end();
        continue;
      }
      if (run.count++ == 0) run.first = brick;
    }
    end();
  });
  return made;
}

BrickLayer layer_of(const BrickLayer& like, std::vector<std::shared_ptr<Brick>> bricks) {
  BrickLayer layer(like.lattice(), like.coset());
  for (size_t slot = 0; slot < bricks.size(); ++slot)
    if (bricks[slot]) layer.set(slot, std::move(bricks[slot]));
  return layer;
}

// Keeps the coefficients that matter, and the holes of the samples.
void finish(std::vector<std::shared_ptr<Brick>>& bricks, const SampleLayer& samples, float prune,
            const BrickBox& region) {
  for (size_t slot = 0; slot < bricks.size(); ++slot) {
    std::shared_ptr<Brick>& brick = bricks[slot];
    const bool inside = region.contains(samples.slot_position(slot));
    const BrickMask* const hole = inside ? samples.brick(slot).hole() : nullptr;
    if (hole && !brick) brick = std::make_shared<Brick>();
    if (!brick) continue;
    const int kept = brick->keep_above(prune);
    if (hole) brick->hole = std::make_unique<BrickMask>(*hole);
    if (!inside || (kept == 0 && !hole)) brick = nullptr;
  }
}

} // namespace

InversePrefilter::InversePrefilter(const PrefilterStage& space, std::span<const PrefilterStage> time)
    : space_(space) {
  std::vector<double> weights{1};
  for (const PrefilterStage& stage : time) {
    const size_t stride = stage.stride;
    std::vector<double> next(weights.size() + 2 * stride);
    for (size_t i = 0; i < weights.size(); ++i) {
      next[i] += stage.temporal * weights[i];
      next[i + stride] += stage.self * weights[i];
      next[i + 2 * stride] += stage.temporal * weights[i];
    }
    weights = std::move(next);
  }
  weights_.assign(weights.begin(), weights.end());
}

BrickLayer InversePrefilter::sum_layers(int32_t layer, const Lattice4& lattice,
                                        const std::map<int32_t, const SampleLayer*>& samples,
                                        const BrickBox& region, const Context& context) const {
  const auto reach = static_cast<int32_t>(weights_.size() / 2);
  std::vector<std::pair<const SampleLayer*, float>> inputs;
  for (int32_t k = -reach; k <= reach; ++k)
    inputs.emplace_back(samples.at(lattice.mirror_layer(layer + k)), weights_[k + reach]);
  BrickLayer sum(lattice.space, lattice.coset(layer));
  context.tasks.parallel_for(sum.rows(), [&](uint64_t row) {
    context.progress.check();
    for (size_t slot = row * sum.row_slots(); slot < (row + 1) * sum.row_slots(); ++slot) {
      if (!region.contains(sum.slot_position(slot))) continue;
      std::shared_ptr<Brick> out;
      std::array<float, brick_sites> room;
      for (const auto& [input, weight] : inputs) {
        const SampleBrick& brick = input->brick(slot);
        if (!brick) continue;
        if (!out) out = std::make_shared<Brick>();
        const float* from = brick.all(room);
        for (size_t i = 0; i < brick_sites; ++i) out->value[i] += weight * from[i];
      }
      if (out) sum.set(slot, std::move(out));
    }
  });
  return sum;
}

BrickLayer InversePrefilter::apply(int32_t layer, const Lattice4& lattice,
                                   const std::map<int32_t, const SampleLayer*>& samples, float prune,
                                   const BrickBox& region, const Context& context) const {
  const BrickBox box = go_round(region.widened(), lattice.space); // its bricks depend on those beside them
  BrickLayer made = sum_layers(layer, lattice, samples, box, context);
  const Reservation room(context.memory, 2 * made.bytes(), "two layers of the inverse filter");
  for (size_t axis = 0; axis < 2; ++axis)
    made = layer_of(made, filter_along(space_, made, axis, box, context));
  auto bricks = filter_along(space_, made, 2, box, context);
  finish(bricks, *samples.at(layer), prune, region);
  return layer_of(made, std::move(bricks));
}

} // namespace bccsplat
#endif
