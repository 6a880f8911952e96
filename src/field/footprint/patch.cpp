// SPDX-License-Identifier: Apache-2.0
#include "field/footprint/patch.h"

#include <array>

namespace bccsplat {

const float* air_brick() {
  alignas(64) static constexpr std::array<float, brick_sites> air{};
  return air.data();
}

} // namespace bccsplat
