// SPDX-License-Identifier: Apache-2.0
#include "points/sample_layer.h"

namespace bccsplat {

uint64_t SampleBrick::bytes() const {
  if (codes) return codes->bytes();
  return values ? sizeof(Brick) + (values->hole ? sizeof(BrickMask) : 0) : 0;
}

const float* SampleBrick::all(std::array<float, brick_sites>& room) const {
  if (values) return values->value.data();
  for (int z = 0; z < brick_edge; ++z) codes->read({.plane = z}, room.data() + z * brick_rows, brick_edge);
  return room.data();
}

SampleLayer::SampleLayer(const BrickLayer& values) : BrickSlots(values.lattice(), values.coset()) {
  for (size_t row = 0; row < values.rows(); ++row)
    for (size_t s = row * row_slots(); !values.row_empty(row) && s < (row + 1) * row_slots(); ++s)
      if (values.brick(s)) set(s, {values.share(s), nullptr});
}

uint64_t SampleLayer::bytes() const {
  uint64_t n = own_bytes();
  for_bricks([&](const SampleBrick& brick) { n += brick.bytes(); });
  return n;
}

} // namespace bccsplat
