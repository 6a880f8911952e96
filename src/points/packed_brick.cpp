// SPDX-License-Identifier: Apache-2.0
#include "points/packed_brick.h"

namespace bccsplat {

std::shared_ptr<const PackedBrick> PackedBrick::pack(const Brick& brick, float finest, float coarsest) {
  constexpr Int3 all{brick_edge, brick_edge, brick_edge};
  const NumberForm form = number_form(brick.value.data(), all, finest, coarsest);
  if (form.bits == 0) return nullptr;
  auto numbers = std::make_unique_for_overwrite<uint8_t[]>(number_bytes(form.bits));
  write_numbers(form, brick.value.data(), numbers.get());
  auto made = std::make_shared<PackedBrick>();
  made->form_ = form;
  made->numbers_ = std::move(numbers);
  made->masks_ = BrickMasks(brick);
  return made;
}

void PackedBrick::read(const PlanePart& part, float* to, std::ptrdiff_t stride) const {
  read_numbers(form_, numbers_.get(), part, to, stride);
}

uint64_t PackedBrick::bytes() const { return sizeof *this + number_bytes(form_.bits) + masks_.bytes(); }

} // namespace bccsplat
