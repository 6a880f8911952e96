// SPDX-License-Identifier: Apache-2.0
#include "fit/direct_layer.h"

#include <algorithm>
#include <cmath>

#include "base/sizes.h"
#include "fit/resample/holes.h"

namespace bccsplat {

DirectLayerScan scan_layer(std::span<const float> samples, float air) {
  DirectLayerScan scan;
  float low = INFINITY, high = -INFINITY;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!std::isfinite(samples[i] - air)) {
      if (scan.nonfinite++ == 0) scan.first_nonfinite = i;
      continue;
    }
    low = std::min(low, samples[i]);
    high = std::max(high, samples[i]);
  }
  scan.finite = samples.size() - scan.nonfinite;
  if (scan.finite > 0) {
    scan.low = low;
    scan.high = high;
  }
  return scan;
}

FrameSites layer_sites(const BrickLayer& shape, std::span<const float> samples, float air, NonFinite policy,
                       const std::array<float, 2>& clamp, SiteBlockPool& pool, const Context& context) {
  // The samples, and what filling holes needs besides.
  const Reservation memory(context.memory, checked_mul(samples.size(), policy == NonFinite::hole ? 24 : 4),
                           "a layer of samples");
  std::vector<float> values(samples.size());
  std::vector<uint8_t> missing;
  for (size_t i = 0; i < samples.size(); ++i) {
    const float v = values[i] = samples[i] - air;
    if (std::isfinite(v)) continue;
    if (policy == NonFinite::hole) {
      missing.resize(samples.size());
      missing[i] = 1;
    } else {
      values[i] = std::isnan(v) ? 0 : v > 0 ? clamp[1] : clamp[0];
    }
  }
  const Int3 n = shape.dims();
  fill_missing(values, missing, {n[0], n[1], n[2]}, context, shape.lattice().periodic);

  FrameSites sites;
  auto& blocks = sites.block[shape.coset()];
  auto& masks = sites.holes[shape.coset()];
  blocks.resize(shape.brick_slots());
  if (!missing.empty()) masks.resize(shape.brick_slots());
  context.tasks.parallel_for(shape.brick_slots(), [&](uint64_t slot) {
    context.progress.check();
    const Int3 brick = shape.slot_position(slot);
    const int64_t width = std::min(brick_edge, n[0] - brick[0] * brick_edge);
    FloatSitesPtr block = pool.floats.take();
    block->source.fill(0xffff), block->near.fill(0xffff); // nothing was filtered, so there is no ringing
    block->largest = 0;
    BrickMask mask{};
    bool any = false, any_missing = false;
    for (int z = 0; z < std::min(brick_edge, n[2] - brick[2] * brick_edge); ++z)
      for (int y = 0; y < std::min(brick_edge, n[1] - brick[1] * brick_edge); ++y) {
        const size_t row = z * brick_edge + y;
        const size_t from = ((int64_t{brick[2]} * brick_edge + z) * n[1] + brick[1] * brick_edge + y) * n[0] +
                            brick[0] * brick_edge;
        for (size_t x = 0; x < static_cast<size_t>(width); ++x) {
          const float v = block->value[row * brick_edge + x] = values[from + x];
          any = any || v != 0;
          if (missing.empty() || !missing[from + x]) continue;
          mask[row] = static_cast<uint16_t>(mask[row] | 1u << x);
          any_missing = true;
        }
      }
    if (any) blocks[slot] = std::move(block);
    if (any_missing) masks[slot] = std::make_unique<BrickMask>(mask);
  });
  return sites;
}

} // namespace bccsplat
