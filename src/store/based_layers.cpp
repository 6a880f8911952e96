// SPDX-License-Identifier: Apache-2.0
#include "store/based_layers.h"

#include <algorithm>

#include "formats/bcc4/field_base.h"

namespace bccsplat {
namespace {

// Calls body(brick, site of the brick) for all that are kept.
template<class B, class Body> void for_kept(B& brick, const Body& body) {
  for (size_t row = 0; row < brick_rows; ++row)
    for (size_t x = 0; x < brick_edge; ++x)
      if (brick.kept[row] >> x & 1) body(brick.value[row * brick_edge + x]);
}

bool is_whole(const BrickLayer& layer) {
  const Int3& n = layer.dims();
  const int64_t all = int64_t{n[0]} * n[1] * n[2];
  return all == layer.kept_sites();
}

} // namespace

void BasedLayers::see(const BrickLayer& layer) {
  whole_ = whole_ && is_whole(layer);
  if (!whole_ || (seen_ && !far_from_air())) return;
  const auto zero = static_cast<double>(air(0));
  for (size_t s = 0; s < layer.brick_slots(); ++s)
    if (const Brick* brick = layer.brick(s))
      for_kept(*brick, [&](float relative) {
        const double value = zero + static_cast<double>(relative);
        if (!seen_) seen_ = Range{value, value};
        seen_->low = std::min(seen_->low, value), seen_->high = std::max(seen_->high, value);
      });
}

bool BasedLayers::far_from_air() const { return whole_ && seen_ && is_far(air(0), *seen_); }

void BasedLayers::settle() { base_ = middle(*seen_); }

BrickLayer BasedLayers::read_layer(int channel, int32_t layer, const BrickBox& region,
                                   const Context& context) const {
  const BrickLayer from_air = window_.read_layer(channel, layer, region, context);
  const double up = static_cast<double>(air(channel)) - static_cast<double>(base_);
  BrickLayer out(from_air.lattice(), from_air.coset());
  for (size_t s = 0; s < out.brick_slots(); ++s) {
    const Brick* brick = from_air.brick(s);
    if (!brick || !region.contains(out.slot_position(s))) continue;
    auto moved = std::make_shared<Brick>();
    moved->value = brick->value, moved->kept = brick->kept;
    if (brick->hole) moved->hole = std::make_unique<BrickMask>(*brick->hole);
    for_kept(*moved, [&](float& v) { v = static_cast<float>(static_cast<double>(v) + up); });
    out.set(s, std::move(moved));
  }
  return out;
}

} // namespace bccsplat
