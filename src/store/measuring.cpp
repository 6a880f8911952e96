// SPDX-License-Identifier: Apache-2.0
#include "store/measuring.h"

#include <algorithm>
#include <numeric>

namespace bccsplat {
namespace {

constexpr uint32_t frames_of_some = 3; // Measure::some; the header of the C ABI promises at most that many

} // namespace

std::vector<uint32_t> Measuring::choose_frames(uint32_t first, uint32_t end) const {
  if (!required_) return choose_level_frames(first, end);
  std::vector<uint32_t> list(end - first);
  std::iota(list.begin(), list.end(), first);
  return list;
}

std::vector<uint32_t> Measuring::choose_level_frames(uint32_t first, uint32_t end) const {
  return wanted_ ? some_frames(first, end) : std::vector<uint32_t>();
}

std::vector<uint32_t> some_frames(uint32_t first, uint32_t end) {
  const uint32_t frames = end - first, count = std::min(frames, frames_of_some);
  std::vector<uint32_t> list;
  for (uint32_t i = 0; i < count; ++i)
    list.push_back(first + static_cast<uint32_t>(uint64_t{frames} * (2 * i + 1) / (2 * count)));
  return list;
}

} // namespace bccsplat
