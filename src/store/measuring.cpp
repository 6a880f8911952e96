// SPDX-License-Identifier: Apache-2.0
#include "store/measuring.h"

#include <algorithm>

namespace bccsplat {
namespace {

constexpr uint32_t frames_of_some = 3; // Measure::some; the header of the C ABI promises at most that many

} // namespace

std::vector<uint32_t> Measuring::choose_frames(uint32_t first, uint32_t end) const {
  if (!wanted_) return {};
  const uint32_t frames = end - first, count = required_ ? frames : std::min(frames, frames_of_some);
  std::vector<uint32_t> list;
  for (uint32_t i = 0; i < count; ++i)
    list.push_back(first +
                   (required_ ? i : static_cast<uint32_t>(uint64_t{frames} * (2 * i + 1) / (2 * count))));
  return list;
}

} // namespace bccsplat
