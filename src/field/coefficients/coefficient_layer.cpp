// SPDX-License-Identifier: Apache-2.0
#include "field/coefficients/coefficient_layer.h"

namespace bccsplat {

bool CoefficientLayer::there(size_t slot) const {
  return values ? values->brick(slot) != nullptr : static_cast<bool>(compact->brick(slot));
}

const float* CoefficientLayer::brick(size_t slot, std::array<float, brick_sites>& room) const {
  if (!there(slot)) return nullptr;
  return values ? values->brick(slot)->value.data() : compact->brick(slot).all(room);
}

const BrickMask* CoefficientLayer::kept(size_t slot) const {
  return values ? &values->brick(slot)->kept : compact->brick(slot).kept();
}

const BrickMask* CoefficientLayer::hole(size_t slot) const {
  return values ? values->brick(slot)->hole.get() : compact->brick(slot).hole();
}

} // namespace bccsplat
