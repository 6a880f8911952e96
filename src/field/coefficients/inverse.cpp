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
#include <atomic>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "base/page_pool.h"
#include "base/pool.h"
#include "field/coefficients/inverse.h"
#include "field/footprint/dense_sites.h"
#include "points/rounded_brick.h"

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
constexpr int reach = PrefilterStage::pole_reach;
using Bricks = std::vector<std::shared_ptr<Brick>>; // by slot; null where nothing is

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

// A brick without values; of: may be null.
std::shared_ptr<Brick> with_holes(const Brick* of) {
  auto brick = make_pooled_for_overwrite<Brick>();
  if (of && of->hole) brick->hole = std::make_unique<BrickMask>(*of->hole);
  return brick;
}

std::shared_ptr<Brick> empty_brick() {
  auto brick = make_pooled_for_overwrite<Brick>();
  brick->value.fill(0);
  return brick;
}

// Some bricks along an axis, from this one on.
struct BrickRun {
  size_t axis;
  Int3 first;
  int count;
};

// The sites of a run and those in reach, as lines along its axis.
class RunSites {
 public:
  // Copies them; false where all are air.
  bool gather(const BrickLayer& from, const BrickRun& run) {
    run_ = run;
    lines_ = {1, run.count * brick_edge + 2 * reach,
              run.axis == 0   ? 1
              : run.axis == 1 ? brick_edge
                              : brick_rows};
    lines_.outer = brick_rows / lines_.inner;
    sites_.resize(std::max(sites_.size(), size_t(lines_.pitch) * brick_rows + beyond));
    const int32_t begin = run.first[run.axis] * brick_edge, end = begin + run.count * brick_edge;
    bool any = gather_sites(from, begin - reach, reach);
    for (Int3 brick = run.first; brick[run.axis] * brick_edge < end; ++brick[run.axis]) {
      const int32_t at = brick[run.axis] * brick_edge;
      if (at + brick_edge > from.dims()[run.axis]) { // beyond the last site are mirror images
        any = gather_sites(from, at, brick_edge) || any;
        continue;
      }
      const Brick* const whole = from.brick(brick[0], brick[1], brick[2]);
      put(whole ? whole->value.data() : nullptr, at, brick_edge);
      any = any || whole;
    }
    return gather_sites(from, end, reach) || any;
  }
  // room: is used.
  void filter(const std::vector<InverseFactor>& factors, std::vector<float>& room) {
    room.resize(std::max(room.size(), sites_.size()));
    int length = lines_.pitch;
    for (const InverseFactor& factor : factors) {
      length -= 2 * factor.stride;
      HWY_DYNAMIC_DISPATCH(ApplyFactor)(factor, lines_, length, sites_.data(), room.data());
      std::swap(sites_, room);
    }
  }
  // Writes what has been filtered, over bricks that are there; others get the holes of `like`.
  void put_into(Bricks& made, const BrickLayer& like) const {
    const size_t part = size_t{brick_edge} * lines_.inner;
    const float* in = sites_.data();
    Int3 brick = run_.first;
    for (int i = 0; i < run_.count; ++i, ++brick[run_.axis], in += part) {
      std::shared_ptr<Brick>& out = made[like.slot(brick[0], brick[1], brick[2])];
      if (!out) out = with_holes(like.brick(brick[0], brick[1], brick[2]));
      for (int o = 0; o < lines_.outer; ++o)
        std::copy_n(in + o * size_t(lines_.pitch) * lines_.inner, part, out->value.data() + o * part);
      clear_beyond(like.dims(), brick, *out);
    }
  }

 private:
  // Puts sites of all lines, `count` along the axis from one of the lattice on; null: air.
  void put(const float* values, int32_t first, int count) {
    const size_t part = size_t(count) * lines_.inner;
    float* to = sites_.data() + size_t(first - run_.first[run_.axis] * brick_edge + reach) * lines_.inner;
    for (int o = 0; o < lines_.outer; ++o, to += size_t(lines_.pitch) * lines_.inner)
      if (values)
        std::copy_n(values + o * part, part, to);
      else
        std::fill_n(to, part, 0.F);
  }
  // The same of sites that may lie beyond the ends of the axis; false where all are air. Across it none
  // beyond the last one are read: their mirror images may be another line's, which is being written.
  bool gather_sites(const BrickLayer& from, int32_t first, int count) {
    SiteBox box;
    Int3 whole{brick_edge, brick_edge, brick_edge};
    for (size_t a = 0; a < 3; ++a) {
      box.origin[a] = run_.first[a] * brick_edge;
      box.size[a] = std::min(brick_edge, from.dims()[a] - box.origin[a]);
    }
    box.origin[run_.axis] = first, box.size[run_.axis] = whole[run_.axis] = count;
    const bool any = gather_box(from, box, some_.data());
    if (any && box.size != whole) spread(box.size, whole);
    put(any ? some_.data() : nullptr, first, count);
    return any;
  }
  // Makes a box of `some_` a larger one, with zeros where it has nothing: from its end on, so that no row is
  // written over before it has moved.
  void spread(const Int3& size, const Int3& whole) {
    for (int z = whole[2]; z-- > 0;)
      for (int y = whole[1]; y-- > 0;) {
        const bool has = z < size[2] && y < size[1];
        float* const to = some_.data() + (size_t(z) * whole[1] + y) * whole[0];
        const float* const row = some_.data() + (size_t(z) * size[1] + y) * size[0];
        if (has) std::memmove(to, row, size_t(size[0]) * sizeof(float));
        std::fill(to + (has ? size[0] : 0), to + whole[0], 0.F);
      }
  }

  BrickRun run_{};
  InverseLines lines_;
  std::vector<float> sites_;
  std::array<float, brick_sites + beyond> some_;
};

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

// What filtering a line takes: runs that follow each other, and room.
struct LineSites {
  std::array<RunSites, 2> runs;
  std::vector<float> room;
};

// Filters lines of bricks along an axis. made: the bricks of `from`, which are written over, or no brick.
// What a run has is written when the next one, which reaches into it, has been copied.
void filter_along(const PrefilterStage& stage, const BrickLayer& from, size_t axis, const BrickBox& region,
                  const Context& context, Pool<LineSites>& lines, Bricks& made) {
  const std::vector<InverseFactor> factors = factors_of(stage);
  Int3 across = from.brick_dims(); // lines of bricks along the axis
  const int bricks = std::exchange(across[axis], 1);
  context.tasks.parallel_for(size_t(across[0]) * across[1] * across[2], [&](uint64_t line) {
    context.progress.check();
    auto sites = lines.take([] { return std::make_unique<LineSites>(); });
    RunSites *now = sites->runs.data(), *before = now + 1; // before: filtered, not written yet
    bool waits = false;
    const auto n = static_cast<int32_t>(line);
    BrickRun run{axis, {n % across[0], n / across[0] % across[1], n / across[0] / across[1]}, 0};
    const auto end = [&] {
      if (run.count > 0 && now->gather(from, run)) {
        if (waits) before->put_into(made, from);
        now->filter(factors, sites->room);
        std::swap(now, before);
        waits = true;
      }
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
    if (waits) before->put_into(made, from);
    lines.give_back(std::move(sites));
  });
}

BrickLayer layer_of(const BrickLayer& like, const Bricks& bricks) {
  BrickLayer layer(like.lattice(), like.coset());
  for (size_t slot = 0; slot < bricks.size(); ++slot)
    if (bricks[slot]) layer.set(slot, bricks[slot]);
  return layer;
}

// The bricks of a layer that nobody else has, which may be written over.
Bricks own_bricks(const BrickLayer& layer) {
  Bricks own(layer.brick_slots());
  for (size_t slot = 0; slot < own.size(); ++slot)
    if (layer.share(slot).use_count() == 1) own[slot] = std::const_pointer_cast<Brick>(layer.share(slot));
  std::atomic_thread_fence(std::memory_order_acquire); // whoever had one before has read it
  return own;
}

// Returns the coefficients of a brick that matter, and its holes.
SampleBrick finished(std::shared_ptr<Brick> brick, const CoefficientForm& form) {
  if (brick->keep_above(form.prune) == 0 && !brick->hole) return {};
  if (form.coarsest > 0)
    if (auto rounded = RoundedBrick::round(*brick, form.coarsest)) return {nullptr, std::move(rounded)};
  return {std::move(brick), nullptr};
}

} // namespace

BrickLayer InversePrefilter::sum_layers(int32_t layer, const Lattice4& lattice,
                                        const std::map<int32_t, const SampleLayer*>& samples,
                                        const BrickBox& region, const Context& context) const {
  const auto reach = static_cast<int32_t>(weights_.size() / 2);
  std::vector<std::pair<const SampleLayer*, float>> inputs;
  for (int32_t k = -reach; k <= reach; ++k)
    inputs.emplace_back(samples.at(lattice.mirror_layer(layer + k)), weights_[k + reach]);
  BrickLayer sum(lattice.space, lattice.coset(layer));
  const bool alone = inputs.size() == 1 && weights_.front() == 1;
  context.tasks.parallel_for(sum.rows(), [&](uint64_t row) {
    context.progress.check();
    for (size_t slot = row * sum.row_slots(); slot < (row + 1) * sum.row_slots(); ++slot) {
      if (!region.contains(sum.slot_position(slot))) continue;
      if (alone && inputs.front().first->brick(slot).values) {
        sum.set(slot, inputs.front().first->brick(slot).values);
        continue;
      }
      std::shared_ptr<Brick> out;
      std::array<float, brick_sites> room;
      for (const auto& [input, weight] : inputs) {
        const SampleBrick& brick = input->brick(slot);
        if (!brick) continue;
        if (!out) out = empty_brick();
        const float* from = brick.all(room);
        for (size_t i = 0; i < brick_sites; ++i) out->value[i] += weight * from[i];
      }
      if (!out) continue;
      if (const BrickMask* hole = samples.at(layer)->brick(slot).hole())
        out->hole = std::make_unique<BrickMask>(*hole);
      sum.set(slot, std::move(out));
    }
  });
  return sum;
}

SampleLayer InversePrefilter::apply(int32_t layer, const Lattice4& lattice,
                                    const std::map<int32_t, const SampleLayer*>& samples,
                                    const CoefficientForm& form, const BrickBox& region,
                                    const Context& context) const {
  const BrickBox box = go_round(region.widened(), lattice.space); // its bricks depend on those beside them
  BrickLayer sum = sum_layers(layer, lattice, samples, box, context);
  const Reservation room(context.memory, sum.bytes(), "a layer of the inverse filter");
  return apply_in_space(std::move(sum), form, region, context);
}

SampleLayer InversePrefilter::apply_in_space(BrickLayer layer, const CoefficientForm& form,
                                             const BrickBox& region, const Context& context) const {
  const Lattice3& space = layer.lattice();
  const BrickBox box = go_round(region.widened(), space);
  Reservation room;
  if (space.periodic[0] || space.periodic[1] || space.periodic[2])
    room = Reservation(context.memory, layer.bytes(), "a layer of the inverse filter");
  Bricks made = own_bricks(layer);
  Pool<LineSites> lines;
  for (size_t axis = 0; axis < 3; ++axis) {
    // Along a periodic axis the last bricks reach into the first ones.
    Bricks written = space.periodic[axis] ? Bricks(made.size()) : made;
    filter_along(space_, layer, axis, box, context, lines, written);
    made = std::move(written);
    layer = layer_of(layer, made);
  }
  SampleLayer result(space, layer.coset());
  layer = {};
  context.tasks.parallel_for(result.rows(), [&](uint64_t row) {
    for (size_t slot = row * result.row_slots(); slot < (row + 1) * result.row_slots(); ++slot)
      if (auto brick = std::move(made[slot]); brick && region.contains(result.slot_position(slot)))
        result.set(slot, finished(std::move(brick), form));
  });
  return result;
}

} // namespace bccsplat
#endif
