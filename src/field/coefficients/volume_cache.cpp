// SPDX-License-Identifier: Apache-2.0
#include "field/coefficients/volume_cache.h"

#include <algorithm>
#include <cmath>

#include "field/coefficients/prefilter_steps.h"
#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

constexpr uint64_t gibibyte = uint64_t{1} << 30;
constexpr double most_over_mean = 2, coefficients_over_samples = 1.5; // bricks, but not more than there are
constexpr uint64_t brick_overhead = 1400; // of codes: which sites are kept, where rows start, allocations

struct LayerCounts {
  uint64_t coefficients = 0, samples = 0;
};

LayerCounts layers_of(const Lattice4& lattice, const Kernel& kernel, bool stored) {
  const auto [own, steps] = prefilter_of(lattice, kernel);
  const auto next = static_cast<uint64_t>(std::ceil(0.5 / lattice.time_step));
  LayerCounts n;
  n.coefficients =
      static_cast<uint64_t>(std::floor(2 * time_reach(own) / kernel_time_per_layer(lattice))) + 1 + next;
  if (!stored && !steps.empty())
    n.samples = n.coefficients + 2 * static_cast<uint64_t>(Prefilter(lattice, steps).reach());
  return n;
}

} // namespace

VolumeCache playing_cache(const Bcc4Reader& reader, const Kernel& kernel) {
  const VolumeInfo& info = reader.info();
  const Lattice4& lattice = info.lattice;
  if (lattice.is_static()) return {};
  const double slots = static_cast<double>(BrickLayer(lattice.space, 0).brick_slots()),
               mean = static_cast<double>(reader.chunk_count()) / std::max(1, info.slabs());
  const double chunks = std::min(most_over_mean * mean, slots * static_cast<double>(info.channels.size())),
               bricks = std::min(most_over_mean * mean, slots),
               made = std::min(coefficients_over_samples * bricks, slots);
  uint64_t code = 1; // bytes; i32 stands for steps, which two bytes hold as a rule
  for (const ChannelInfo& c : info.channels)
    code = std::max<uint64_t>(code, c.type == ValueType::i32 ? 2 : value_bytes(c.type));
  const uint64_t coded = code * brick_sites + brick_overhead;
  const bool stores_coefficients = !info.coefficient_kernel.empty(),
             values = stores_coefficients || std::any_of(info.channels.begin(), info.channels.end(),
                                                         [](const auto&c) { return is_float(c.type); });
  const LayerCounts layers = layers_of(
      lattice, kernel, make_kernel(info.coefficient_kernel).name == kernel.name && stores_coefficients);
  const double slot_bytes = slots * sizeof(SampleBrick);
  const auto bytes = [&](uint64_t count, double of_bricks, uint64_t each) {
    return static_cast<uint64_t>(static_cast<double>(count) *
                                 (of_bricks * static_cast<double>(each) + slot_bytes));
  };
  VolumeCache need;
  need.chunks = bytes(static_cast<uint64_t>(info.slab_layers), chunks, coded);
  need.coefficients = bytes(layers.coefficients, made, sizeof(Brick)) +
                      bytes(layers.samples, bricks, values ? sizeof(Brick) : coded);
  return need;
}

VolumeCache share_cache(uint64_t bytes, const VolumeCache& playing) {
  const uint64_t beyond = bytes - std::min(bytes, playing.bytes());
  VolumeCache share;
  share.chunks = std::min(bytes / 4, playing.chunks + beyond / 4);
  share.coefficients = bytes - share.chunks;
  return share;
}

uint64_t default_cache_bytes(const VolumeCache& playing, uint64_t budget, uint64_t memory) {
  const uint64_t least = std::min(budget / 4, gibibyte);
  return std::max(least, std::min({playing.bytes(), budget / 4, memory / 2}));
}

} // namespace bccsplat
