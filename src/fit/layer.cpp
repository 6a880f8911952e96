// Combines frames to a layer, brick by brick: weighted differences from the nearest frame, then rounding and
// relevance.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/layer.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "fit/layer.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// out = center + sum over k of weight[k] * (block[k] - center), for the first `planes` planes and `rows` rows
// of each.
void Combine(const float* HWY_RESTRICT center, const float* const* blocks, const float* weights, size_t count,
             size_t planes, size_t rows, float* HWY_RESTRICT out) {
  const hn::CappedTag<float, 16> d;
  for (size_t z = 0; z < planes; ++z)
    for (size_t i = z * 256; i < z * 256 + rows * 16; i += hn::Lanes(d)) {
      const auto base = hn::Load(d, center + i);
      auto sum = hn::Zero(d); // of small numbers when little changes
      for (size_t k = 0; k < count; ++k)
        sum = hn::Add(hn::Mul(hn::Set(d, weights[k]), hn::Sub(hn::Load(d, blocks[k] + i), base)), sum);
      hn::Store(hn::Add(base, sum), d, out + i);
    }
}

// |made - stored| of the first `columns` of the first `rows` of `planes`: sixteen sums of squares and largest
// values each, so that nothing depends on the width of vectors.
void Compare(const float* HWY_RESTRICT made, const float* HWY_RESTRICT stored, size_t planes, size_t rows,
             size_t columns, double* HWY_RESTRICT squares, float* HWY_RESTRICT largest) {
  for (size_t z = 0; z < planes; ++z)
    for (size_t i = z * 256; i < z * 256 + rows * 16; i += 16)
      for (size_t x = 0; x < columns; ++x) {
        const float d = made[i + x] - stored[i + x];
        const float magnitude = d < 0 ? -d : d;
        largest[x] = magnitude > largest[x] ? magnitude : largest[x];
        squares[x] += static_cast<double>(d) * static_cast<double>(d);
      }
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace bccsplat {
HWY_EXPORT(Combine);
HWY_EXPORT(Compare);

namespace {
const SiteBlock air_block{};
const BrickMask no_source{};
} // namespace

BrickLayer LayerMaker::make(const Lattice3& lattice, int coset, std::span<const LayerTap> taps,
                            size_t nearest, bool beyond, const Context& context) {
  BrickLayer layer(lattice, coset);
  const auto c = static_cast<size_t>(coset);
  const auto holes_of = [&](size_t slot) -> const BrickMask* {
    const auto& holes = taps[nearest].frame->holes[c];
    return holes.empty() ? nullptr : holes[slot].get();
  };
  std::vector<size_t> slots;
  for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
    bool any = holes_of(slot) != nullptr;
    for (const LayerTap& tap : taps) any = any || tap.frame->block[c][slot];
    if (any) slots.push_back(slot);
  }
  std::vector<CodingError> coding(slots.size());
  constexpr size_t group = 4; // bricks of a task
  context.tasks.parallel_for((slots.size() + group - 1) / group, [&](uint64_t g) {
    context.progress.check();
    std::unique_ptr<SiteCounts> counts;
    {
      const std::scoped_lock lock(mutex_);
      if (!counts_.empty()) {
        counts = std::move(counts_.back());
        counts_.pop_back();
      }
    }
    if (!counts) counts = std::make_unique<SiteCounts>(SiteCounts{{}, SampleHistogram(quantiser_)});
    std::vector<const float*> blocks;
    std::vector<float> weights;
    SiteBlock combined;
    for (size_t s = g * group; s < std::min(slots.size(), (g + 1) * group); ++s) {
      const size_t slot = slots[s];
      const auto block = [&](size_t k) {
        const SiteBlockPtr& b = taps[k].frame->block[c][slot];
        return b ? b->value.data() : air_block.value.data();
      };
      blocks.clear();
      weights.clear();
      for (size_t k = 0; k < taps.size(); ++k) {
        if (k == nearest || taps[k].weight == 0 || block(k) == block(nearest)) continue;
        blocks.push_back(block(k));
        weights.push_back(taps[k].weight);
      }
      const Int3 position = layer.slot_position(slot);
      Int3 size;
      for (size_t a = 0; a < 3; ++a)
        size[a] = std::min(brick_edge, layer.dims()[a] - position[a] * brick_edge);
      const float* values = block(nearest);
      if (!blocks.empty()) {
        HWY_DYNAMIC_DISPATCH(Combine)
        (values, blocks.data(), weights.data(), blocks.size(), static_cast<size_t>(size[2]),
         static_cast<size_t>(size[1]), combined.value.data());
        values = combined.value.data();
      }
      SiteEvidence evidence{holes_of(slot), &no_source, 0};
      if (const SiteBlockPtr& b = taps[nearest].frame->block[c][slot]) evidence.source = &b->source;
      for (const LayerTap& tap : taps)
        if (const SiteBlockPtr& b = tap.frame->block[c][slot])
          evidence.ringing = std::max(evidence.ringing, ringing_ * b->largest);
      auto brick = std::make_shared_for_overwrite<Brick>();
      const KeptCounts found = relevance_.select(values, size, evidence, *brick);
      std::array<double, 16> squares{};
      std::array<float, 16> largest{};
      HWY_DYNAMIC_DISPATCH(Compare)
      (values, brick->value.data(), static_cast<size_t>(size[2]), static_cast<size_t>(size[1]),
       static_cast<size_t>(size[0]), squares.data(), largest.data());
      for (size_t x = 0; x < 16 && !beyond; ++x) {
        coding[s].squares += squares[x];
        coding[s].largest = std::max(coding[s].largest, static_cast<double>(largest[x]));
      }
      counts->sites.kept += found.kept;
      counts->sites.holes += found.holes;
      if (!beyond) counts->sites.clamped += found.clamped;
      if (found.kept == 0) continue;
      counts->samples.add(*brick);
      layer.set(slot, std::move(brick));
    }
    const std::scoped_lock lock(mutex_);
    counts_.push_back(std::move(counts));
  });
  for (const CodingError& e : coding) {
    coding_.squares += e.squares;
    coding_.largest = std::max(coding_.largest, e.largest);
  }
  return layer;
}

uint64_t LayerMaker::clamped() const {
  uint64_t sum = 0;
  for (const auto& part : counts_) sum += part->sites.clamped;
  return sum;
}

SiteCounts LayerMaker::counts() const {
  SiteCounts all{{}, SampleHistogram(quantiser_)};
  for (const auto& part : counts_) {
    all.sites.kept += part->sites.kept;
    all.sites.holes += part->sites.holes;
    all.sites.clamped += part->sites.clamped;
    all.samples.merge(part->samples);
  }
  return all;
}

} // namespace bccsplat
#endif
