// SPDX-License-Identifier: Apache-2.0
#include "points/absent.h"

#include <algorithm>
#include <memory>

namespace bccsplat {
namespace {

// The sites of a brick that are inside the coset.
BrickMask inside(const BrickLayer& layer, const Int3& brick) {
  std::array<int32_t, 3> n;
  for (size_t a = 0; a < 3; ++a) n[a] = std::min(brick_edge, layer.dims()[a] - brick[a] * brick_edge);
  const auto row = static_cast<uint16_t>((1u << n[0]) - 1);
  BrickMask mask{};
  for (int32_t z = 0; z < n[2]; ++z)
    for (int32_t y = 0; y < n[1]; ++y) mask[z * brick_edge + y] = row;
  return mask;
}

} // namespace

void fill_absent(BrickLayer& layer, const BrickBox& region, float value) {
  for (size_t s = 0; s < layer.brick_slots(); ++s) {
    const Int3 at = layer.slot_position(s);
    if (!region.contains(at)) continue;
    const BrickMask all = inside(layer, at);
    const Brick* const stored = layer.brick(s);
    if (stored && stored->kept == all) continue;
    auto filled = std::make_shared<Brick>();
    if (stored) {
      filled->value = stored->value, filled->kept = stored->kept;
      if (stored->hole) filled->hole = std::make_unique<BrickMask>(*stored->hole);
    }
    for (size_t row = 0; row < brick_rows; ++row) {
      const int absent = all[row] & ~filled->kept[row];
      for (size_t x = 0; absent != 0 && x < brick_edge; ++x)
        if (absent >> x & 1) filled->value[row * brick_edge + x] = value;
      filled->kept[row] = all[row];
    }
    layer.set(s, std::move(filled));
  }
}

} // namespace bccsplat
