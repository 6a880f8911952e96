// SPDX-License-Identifier: Apache-2.0
// Combines frames to a layer, brick by brick: weighted differences from the nearest frame, then rounding and
// relevance.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/kept/layer.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "base/page_pool.h"
#include "fit/kept/layer.h"
#include "fit/kept/packed_block.h"
#include "formats/bcc4/coding/layer_codes.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// out = center + sum over k of weight[k] * (plane[k] - center), for the first `rows` rows of a plane.
void Combine(const float* HWY_RESTRICT center, const float* const* planes, const float* weights, size_t count,
             size_t rows, float* HWY_RESTRICT out) {
  const hn::CappedTag<float, 16> d;
  for (size_t i = 0; i < rows * 16; i += hn::Lanes(d)) {
    const auto base = hn::Load(d, center + i);
    auto sum = hn::Zero(d); // of small numbers when little changes
    for (size_t k = 0; k < count; ++k)
      sum = hn::Add(hn::Mul(hn::Set(d, weights[k]), hn::Sub(hn::Load(d, planes[k] + i), base)), sum);
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
        squares[x] += static_cast<double>(d) * d;
      }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Combine);
HWY_EXPORT(Compare);

namespace {
const BrickMask no_source{};

struct alignas(64) PlaneValues : std::array<float, brick_rows> {};
const PlaneValues air_plane{};

// One brick in the frames of a layer's taps; null: air.
struct BrickTaps {
  const SiteBlock* center = nullptr;
  std::vector<const SiteBlock*> blocks; // and how much their differences from it count
  std::vector<float> weights;
};

// Room for the values of one brick.
struct BrickRoom {
  SiteValues sum;
  std::vector<PlaneValues> unpacked; // a plane of the center, and of each block
  std::vector<uint32_t> codes;
};

void combine(const BrickTaps& taps, const Int3& size, BrickRoom& room) {
  const size_t count = taps.blocks.size();
  room.unpacked.resize(std::max(room.unpacked.size(), count + 1));
  std::vector<const float*> planes(count);
  for (int z = 0; z < size[2]; ++z) {
    const auto plane = [&](const SiteBlock* block, size_t k) {
      return block ? plane_of(*block, z, room.unpacked[k].data()) : air_plane.data();
    };
    for (size_t k = 0; k < count; ++k) planes[k] = plane(taps.blocks[k], k);
    HWY_DYNAMIC_DISPATCH(Combine)
    (plane(taps.center, count), planes.data(), taps.weights.data(), count, static_cast<size_t>(size[1]),
     room.sum.data() + z * brick_rows);
  }
}

// Makes these sites of a brick air.
void clear_sites(const BrickMask& sites, SiteValues& values) {
  for (size_t i = 0; i < values.size(); ++i)
    if (sites[i / brick_edge] >> (i % brick_edge) & 1) values[i] = 0;
}

// Counts the samples of a brick, those that fill holes excepted.
void count_samples(Brick& brick, const LayerCodes* codes, const BrickMask* fills, SampleHistogram& samples,
                   std::vector<uint32_t>& room) {
  if (codes && !fills && !brick.hole) {
    room.clear();
    codes->append_codes(room);
    return samples.add_codes(room);
  }
  if (!fills) return samples.add(brick);
  brick.hole = std::make_unique<BrickMask>(*fills);
  samples.add(brick);
  brick.hole.reset();
}

// Adds the distances of stored values from those made.
void compare(const float* made, const Brick& stored, const Int3& size, CodingError& error) {
  std::array<double, 16> squares{};
  std::array<float, 16> largest{};
  HWY_DYNAMIC_DISPATCH(Compare)
  (made, stored.value.data(), size[2], size[1], size[0], squares.data(), largest.data());
  for (size_t x = 0; x < 16; ++x) {
    error.squares += squares[x];
    error.largest = std::max(error.largest, static_cast<double>(largest[x]));
  }
}

} // namespace

struct LayerMaker::Frames {
  std::span<const LayerTap> taps;
  size_t nearest;
  size_t coset;

  [[nodiscard]] bool masked() const { return taps[nearest].frame->masked; }
  [[nodiscard]] const SiteBlock* block(size_t tap, size_t slot) const {
    return taps[tap].frame->block[coset][slot].get();
  }
  [[nodiscard]] const BrickMask* holes(size_t slot) const {
    const auto& holes = taps[nearest].frame->holes[coset];
    return holes.empty() ? nullptr : holes[slot].get();
  }
  // Returns the slots, of so many, that have sites or holes.
  [[nodiscard]] std::vector<size_t> used_slots(size_t count) const {
    std::vector<size_t> slots;
    for (size_t slot = 0; slot < count; ++slot) {
      bool any = !masked() && holes(slot) != nullptr;
      for (size_t k = 0; k < taps.size(); ++k) any = any || block(k, slot);
      if (any) slots.push_back(slot);
    }
    return slots;
  }
  // Finds the blocks of a brick that differ from that of the nearest frame.
  void find_taps(size_t slot, BrickTaps& out) const {
    out.center = block(nearest, slot);
    out.blocks.clear(), out.weights.clear();
    for (size_t k = 0; k < taps.size(); ++k) {
      if (k == nearest || taps[k].weight == 0 || block(k, slot) == out.center) continue;
      out.blocks.push_back(block(k, slot));
      out.weights.push_back(taps[k].weight);
    }
  }
  // Finds the sites of a brick that are missing far from all data in every frame; false: there are none.
  [[nodiscard]] bool deep_sites(size_t slot, BrickMask& deep) const {
    deep.fill(0xffff);
    for (const LayerTap& tap : taps) {
      const auto& masks = tap.frame->deep[coset];
      if (masks.empty() || !masks[slot]) return false;
      for (size_t r = 0; r < brick_rows; ++r) deep[r] &= (*masks[slot])[r];
    }
    return deep != BrickMask{};
  }
};

struct LayerMaker::Room {
  BrickTaps taps;
  BrickRoom values;
  SiteCounts* counts = nullptr; // null: the brick is not counted
};

SiteEvidence LayerMaker::evidence_of(const Frames& frames, size_t slot, BrickMask& near) const {
  SiteEvidence evidence{frames.masked() ? nullptr : frames.holes(slot), &no_source, 0};
  if (const SiteBlock* b = frames.block(frames.nearest, slot)) evidence.source = &b->source;
  if (ringing_ > 0) evidence.near = &near;
  for (size_t k = 0; k < frames.taps.size(); ++k)
    if (const SiteBlock* b = frames.block(k, slot)) {
      evidence.ringing = std::max(evidence.ringing, ringing_ * b->largest);
      for (size_t r = 0; r < brick_rows; ++r) near[r] |= b->near[r];
    }
  return evidence;
}

SampleBrick LayerMaker::make_brick(const Frames& frames, size_t slot, const Int3& size, bool beyond,
                                   Room& room, CodingError& coding) const {
  frames.find_taps(slot, room.taps);
  combine(room.taps, size, room.values);
  if (BrickMask deep; frames.deep_sites(slot, deep)) clear_sites(deep, room.values.sum);
  const float* values = room.values.sum.data();
  BrickMask near{};
  const SiteEvidence evidence = evidence_of(frames, slot, near);
  auto brick = make_pooled_for_overwrite<Brick>();
  const KeptCounts found = relevance_.select(values, size, evidence, *brick);
  if (room.counts) {
    if (!beyond) compare(values, *brick, size, coding);
    room.counts->sites.kept += found.kept;
    room.counts->sites.holes += found.holes;
    if (!beyond) room.counts->sites.clamped += found.clamped;
  }
  if (found.kept == 0) return {};
  auto codes = LayerCodes::of(coder_, *brick);
  if (room.counts)
    count_samples(*brick, codes.get(), frames.masked() ? frames.holes(slot) : nullptr, room.counts->samples,
                  room.values.codes);
  if (codes) return {nullptr, std::move(codes)};
  return {std::move(brick), nullptr};
}

MadeLayer LayerMaker::make(const Lattice3& lattice, int coset, std::span<const LayerTap> taps, size_t nearest,
                           bool beyond, const Context& context, const LayerBricks& bricks) {
  SampleLayer layer(lattice, coset);
  SharedReservation memory(context.memory);
  const Frames frames{taps, nearest, static_cast<size_t>(coset)};
  std::vector<size_t> slots = frames.used_slots(layer.brick_slots());
  std::erase_if(slots, [&](size_t slot) { return !bricks.made.contains(layer.slot_position(slot)); });
  std::vector<CodingError> coding(slots.size());
  constexpr size_t group = 4; // bricks of a task
  context.tasks.parallel_for((slots.size() + group - 1) / group, [&](uint64_t g) {
    context.progress.check();
    auto counts = counts_.take([&] {
      return std::make_unique<SiteCounts>(SiteCounts{{}, SampleHistogram(quantiser_)});
    });
    Room room{{}, {}};
    uint64_t bytes = 0;
    for (size_t s = g * group; s < std::min(slots.size(), (g + 1) * group); ++s) {
      const Int3 position = layer.slot_position(slots[s]);
      Int3 size;
      for (size_t a = 0; a < 3; ++a)
        size[a] = std::min(brick_edge, layer.dims()[a] - position[a] * brick_edge);
      room.counts = bricks.counted.contains(position) ? counts.get() : nullptr;
      SampleBrick brick = make_brick(frames, slots[s], size, beyond, room, coding[s]);
      bytes += brick.bytes();
      if (brick) layer.set(slots[s], std::move(brick));
    }
    memory.add(bytes, "a slab of layers"); // which bricks are codes is known when they are there
    counts_.give_back(std::move(counts));
  });
  for (const CodingError& e : coding) {
    coding_.squares += e.squares;
    coding_.largest = std::max(coding_.largest, e.largest);
  }
  return {std::move(layer), memory.take()};
}

uint64_t LayerMaker::clamped() const {
  uint64_t sum = 0;
  for (const auto& part : counts_.idle()) sum += part->sites.clamped;
  return sum;
}

SiteCounts LayerMaker::counts() const {
  SiteCounts all{{}, SampleHistogram(quantiser_)};
  for (const auto& part : counts_.idle()) {
    all.sites.kept += part->sites.kept;
    all.sites.holes += part->sites.holes;
    all.sites.clamped += part->sites.clamped;
    all.samples.merge(part->samples);
  }
  return all;
}

} // namespace bccsplat
#endif
