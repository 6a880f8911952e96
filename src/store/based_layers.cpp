// SPDX-License-Identifier: Apache-2.0
#include "store/based_layers.h"

#include "points/absent.h"

namespace bccsplat {

void BasedLayers::see(const SampleLayer& layer) {
  const Int3& n = layer.dims();
  sites_ += int64_t{n[0]} * n[1] * n[2];
  for (size_t s = 0; s < layer.brick_slots(); ++s) {
    const auto brick = layer.brick(s).as_values();
    if (!brick) continue;
    kept_ += brick->count();
    seen_.add(*brick);
  }
}

StoredValues BasedLayers::values() const {
  const auto at = [&](size_t i) { return seen_.percentile(most_percent[i] / 100); };
  return {seen_.range(), {at(0), at(2)}, static_cast<float>(at(1))};
}

bool BasedLayers::far_from_air() const { return nearly_all(kept_, sites_) && is_far(air(0), values()); }

void BasedLayers::settle() { base_ = values().median; }

BrickLayer BasedLayers::read_layer(int channel, int32_t layer, const BrickBox& region,
                                   const Context& context) const {
  const BrickLayer from_air = window_.read_layer(channel, layer, region, context);
  const double up = static_cast<double>(air(channel)) - base_;
  BrickLayer out(from_air.lattice(), from_air.coset());
  for (size_t s = 0; s < out.brick_slots(); ++s) {
    const Brick* brick = from_air.brick(s);
    if (!brick || !region.contains(out.slot_position(s))) continue;
    auto moved = std::make_shared<Brick>();
    moved->kept = brick->kept;
    if (brick->hole) moved->hole = std::make_unique<BrickMask>(*brick->hole);
    for (size_t site = 0; site < brick_sites; ++site)
      if (brick->kept[site / brick_edge] >> (site % brick_edge) & 1)
        moved->value[site] = static_cast<float>(brick->value[site] + up);
    out.set(s, std::move(moved));
  }
  fill_absent(out, region, static_cast<float>(up));
  return out;
}

} // namespace bccsplat
