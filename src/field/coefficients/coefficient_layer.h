// SPDX-License-Identifier: Apache-2.0
// A layer of coefficients in one of two forms, with the same values.
#pragma once

#include <memory>

#include "points/brick.h"
#include "points/sample_layer.h"

namespace bccsplat {

struct CoefficientLayer {
  std::shared_ptr<const BrickLayer> values;
  std::shared_ptr<const SampleLayer> compact;
  explicit operator bool() const { return values || compact; }

  [[nodiscard]] size_t brick_slots() const { return values ? values->brick_slots() : compact->brick_slots(); }
  // The values of a brick, which `room` is for where they are codes; null where all is air.
  [[nodiscard]] const float* brick(size_t slot, std::array<float, brick_sites>& room) const;
  // Which of its sites are kept and which are holes; null: all are, none is. The brick is there.
  [[nodiscard]] bool there(size_t slot) const;
  [[nodiscard]] const BrickMask* kept(size_t slot) const;
  [[nodiscard]] const BrickMask* hole(size_t slot) const;
};

} // namespace bccsplat
