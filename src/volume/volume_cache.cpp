// SPDX-License-Identifier: Apache-2.0
// Counts what a series that plays needs at a time: layers of coefficients, and what they are made of.
#include "volume/volume_cache.h"

#include <algorithm>
#include <cmath>

#include "field/coefficients/prefilter_steps.h"
#include "formats/bcc4/sample_step.h"
#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"
#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

constexpr uint64_t gibibyte = uint64_t{1} << 30;
constexpr double most_over_mean = 2, coefficients_over_samples = 1.5; // bricks, but not more than there are
// Bytes beside the codes of a brick; and where some sites are left out, to say which, and where rows start.
constexpr uint64_t code_overhead = 200, rounded_overhead = 64, part_overhead = 1200;
constexpr double whole_share = 0.98; // of the sites of u8, which are kept where air is scattered among them

struct LayerCounts {
  uint64_t coefficients = 0;
  uint64_t samples = 0, first_samples = 0; // for the next moment, and for the first
};

// The share of the bricks of a layer whose sites are not all inside the coset.
double outer_share(const Lattice3& lattice) {
  double inner = 1;
  for (const int32_t n : lattice.dims(0))
    inner *= static_cast<double>(n / brick_edge) / ((n + brick_edge - 1) / brick_edge);
  return 1 - inner;
}

// Returns whether inside the coset bricks of which some sites are left out are few.
bool is_whole(const VolumeInfo& info) {
  const auto sites = static_cast<uint64_t>(info.lattice.sites());
  return std::all_of(info.channels.begin(), info.channels.end(), [&](const ChannelInfo& c) {
    const double share = c.type == ValueType::u8 ? whole_share : 1;
    return static_cast<double>(c.sites_kept) >= share * static_cast<double>(sites);
  });
}

// linear: of samples only the layer that coefficients are made of is held.
LayerCounts layers_of(const Lattice4& lattice, const Kernel& kernel, bool linear) {
  const auto [own, steps, in_space] = prefilter_of(lattice, kernel);
  const auto next = static_cast<uint64_t>(std::ceil(0.5 / lattice.time_step));
  LayerCounts n;
  n.coefficients =
      static_cast<uint64_t>(std::floor(2 * time_reach(own) / kernel_time_per_layer(lattice))) + 1;
  if (steps.empty()) return n;
  if (linear) { // and a still, see Coefficients::compact_layers()
    n.samples = 1, n.coefficients += interpolates_on_cc(own) ? 1 : 0;
    return n;
  }
  const uint64_t around = 2 * static_cast<uint64_t>(Prefilter(lattice, steps).reach());
  n.samples = next + around, n.first_samples = n.coefficients + around;
  return n;
}

} // namespace

VolumeCache playing_cache(const Bcc4Reader& reader, const Kernel& kernel) {
  const VolumeInfo& info = reader.info();
  const Lattice4& lattice = info.lattice;
  if (lattice.is_static()) return {};
  const bool linear =
      std::all_of(info.channels.begin(), info.channels.end(), [](const auto& c) { return c.linear; });
  const double slots = static_cast<double>(BrickLayer(lattice.space, 0).brick_slots()),
               of_chunk = std::pow(info.tile_edge, 3),
               mean = static_cast<double>(reader.chunk_count()) * of_chunk / std::max(1, info.slabs());
  const double chunks = std::min(most_over_mean * mean, slots * static_cast<double>(info.channels.size())),
               bricks = std::min(most_over_mean * mean, slots),
               made = std::min(coefficients_over_samples * bricks, slots);
  uint64_t code = 1; // bytes
  for (const ChannelInfo& c : info.channels) code = std::max<uint64_t>(code, value_bytes(c.type));
  const double parts = is_whole(info) ? outer_share(lattice.space) : 1;
  const auto beside = static_cast<uint64_t>(parts * static_cast<double>(part_overhead));
  const uint64_t coded = code * brick_sites + code_overhead + beside;
  const bool values =
      std::any_of(info.channels.begin(), info.channels.end(), [](const auto& c) { return is_float(c.type); });
  const LayerCounts layers = layers_of(lattice, kernel, linear);
  const double slot_bytes = slots * sizeof(SampleBrick);
  const auto bytes = [&](uint64_t count, double of_bricks, uint64_t each) {
    return static_cast<uint64_t>(static_cast<double>(count) *
                                 (of_bricks * static_cast<double>(each) + slot_bytes));
  };
  VolumeCache need;
  // Lists of coefficients take about two bytes for each site of a layer.
  need.chunks = linear ? bytes(1, chunks, 2 * brick_sites) : bytes(info.slab_layers, chunks, coded);
  // Bytes mostly fit the steps of rounded coefficients, which Cartesian lattices have of linear samples
  // alone.
  const bool rounded = (lattice.space.bcc || linear) &&
                       std::all_of(info.channels.begin(), info.channels.end(), [](const auto& c) {
                         return c.type == ValueType::u8 && sample_step(c) > 0;
                       });
  const uint64_t sample = values || linear ? sizeof(Brick) : coded;
  need.coefficients =
      std::max(bytes(layers.coefficients, made,
                     rounded ? sizeof(RoundedBrick) + rounded_overhead + beside / 2 : sizeof(Brick)) +
                   bytes(layers.samples, bricks, sample),
               bytes(layers.first_samples, bricks, sample));
  return need;
}

VolumeCache share_cache(uint64_t bytes, const VolumeCache& playing) {
  const uint64_t beyond = bytes - std::min(bytes, playing.bytes());
  VolumeCache share;
  share.chunks = std::min(bytes / 3, playing.chunks + beyond / 4);
  share.coefficients = bytes - share.chunks;
  return share;
}

uint64_t default_cache_bytes(const VolumeCache& playing, uint64_t budget, uint64_t memory) {
  const uint64_t least = std::min(budget / 4, gibibyte);
  return std::max(least, std::min({playing.bytes(), budget / 4, memory / 2}));
}

} // namespace bccsplat
