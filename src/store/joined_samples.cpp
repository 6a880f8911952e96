// SPDX-License-Identifier: Apache-2.0
#include "store/joined_samples.h"

#include <algorithm>

namespace bccsplat {
namespace {

bool have_common(const BrickBox& a, const BrickBox& b) {
  for (size_t i = 0; i < 3; ++i)
    if (std::max(a.begin[i], b.begin[i]) >= std::min(a.end[i], b.end[i])) return false;
  return true;
}

// No brick is in two parts.
void put_into(const BrickLayer& read, BrickLayer& all) {
  for (size_t r = 0; r < read.rows(); ++r) {
    if (read.row_empty(r)) continue;
    for (size_t s = r * read.row_slots(); s < (r + 1) * read.row_slots(); ++s)
      if (read.brick(s)) all.set(s, read.share(s));
  }
}

} // namespace

JoinedSamples::JoinedSamples(const SeriesParts& parts, int level, MemoryBudget& budget,
                             uint64_t cache_bytes) {
  for (const auto& part : parts) {
    const VolumeInfo& info = part->info();
    parts_.push_back(
        {bricks_of(info.part->block, info.level(level).lattice),
         std::make_unique<Bcc4Samples>(part, budget, cache_bytes / parts.size(), RelativeTo::air, level)});
  }
}

BrickLayer JoinedSamples::read_layer(int channel, int32_t layer, const BrickBox& region,
                                     const Context& context) const {
  BrickLayer all;
  read_layers(channel, std::span(&layer, 1), region, context,
              [&](int32_t, BrickLayer&& read) { all = std::move(read); });
  return all;
}

void JoinedSamples::read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                                const Context& context, const TakeLayer<BrickLayer>& take) const {
  std::vector<BrickLayer> all;
  for (const int32_t m : layers) all.emplace_back(lattice().space, lattice().coset(m));
  for (const Part& part : parts_) {
    if (!have_common(part.bricks, region)) continue;
    size_t i = 0;
    part.samples->read_layers(channel, layers, region, context,
                              [&](int32_t, BrickLayer&& read) { put_into(read, all[i++]); });
  }
  for (size_t i = 0; i < layers.size(); ++i) take(layers[i], std::move(all[i]));
}

} // namespace bccsplat
