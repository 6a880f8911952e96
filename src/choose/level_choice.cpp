// SPDX-License-Identifier: Apache-2.0
#include "choose/level_choice.h"

#include <algorithm>

namespace bccsplat::series {

uint32_t levels_for(const std::array<uint64_t, 4>& dims) {
  constexpr double small_frame = 96.0 * 96 * 96;
  std::array<uint64_t, 3> n{dims[0], dims[1], dims[2]};
  const auto samples = [&] {
    return static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
  };
  if (samples() < 8 * small_frame) return 0;
  uint32_t levels = 0;
  for (; samples() > small_frame; ++levels)
    for (uint64_t& length : n) length = (length + 1) / 2;
  return levels;
}

} // namespace bccsplat::series
