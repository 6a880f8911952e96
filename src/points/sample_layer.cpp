// SPDX-License-Identifier: Apache-2.0
#include "points/sample_layer.h"

#include <algorithm>

#include "base/page_pool.h"

namespace bccsplat {

BrickMasks::BrickMasks(const Brick& brick) {
  if (std::any_of(brick.kept.begin(), brick.kept.end(), [](uint16_t row) { return row != 0xffff; }))
    kept = std::make_unique<const BrickMask>(brick.kept);
  if (brick.hole) hole = std::make_unique<const BrickMask>(*brick.hole);
}

uint64_t SampleBrick::bytes() const {
  if (codes) return codes->bytes();
  return values ? sizeof(Brick) + (values->hole ? sizeof(BrickMask) : 0) : 0;
}

const float* SampleBrick::all(std::array<float, brick_sites>& room) const {
  if (values) return values->value.data();
  for (int z = 0; z < brick_edge; ++z) codes->read({.plane = z}, room.data() + z * brick_rows, brick_edge);
  return room.data();
}

std::shared_ptr<const Brick> SampleBrick::as_values() const {
  if (!codes) return values;
  auto brick = make_pooled_for_overwrite<Brick>();
  (void)all(brick->value);
  if (const BrickMask* some = codes->kept())
    brick->kept = *some;
  else
    brick->kept.fill(0xffff);
  if (const BrickMask* missing = codes->hole()) brick->hole = std::make_unique<BrickMask>(*missing);
  return brick;
}

SampleLayer::SampleLayer(const BrickLayer& values) : BrickSlots(values.lattice(), values.coset()) {
  for (size_t row = 0; row < values.rows(); ++row)
    for (size_t s = row * row_slots(); !values.row_empty(row) && s < (row + 1) * row_slots(); ++s)
      if (values.brick(s)) set(s, {values.share(s), nullptr});
}

BrickLayer SampleLayer::as_values() const {
  BrickLayer values(lattice(), coset());
  for (size_t row = 0; row < rows(); ++row)
    for (size_t s = row * row_slots(); !row_empty(row) && s < (row + 1) * row_slots(); ++s)
      if (const SampleBrick& b = brick(s)) values.set(s, b.as_values());
  return values;
}

uint64_t SampleLayer::bytes() const {
  uint64_t n = own_bytes();
  for_bricks([&](const SampleBrick& brick) { n += brick.bytes(); });
  return n;
}

} // namespace bccsplat
