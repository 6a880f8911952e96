// SPDX-License-Identifier: Apache-2.0
// How many bits a magnitude takes where another is expected, counted from magnitudes that were chosen before.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "formats/bcc4/wavelet/band_walk.h"

namespace bccsplat {

class BitCosts {
 public:
  BitCosts();
  void count(int level, uint32_t expected, int magnitude, uint32_t times = 1) {
    counts_[index(level, expected)][magnitude < symbols ? magnitude : symbols - 1] += times;
  }
  // Makes costs of what was counted since the last time.
  void settle();
  [[nodiscard]] float bits(int level, uint32_t expected, int magnitude) const {
    constexpr float a_bit_more = 2.0F;
    const auto& row = bits_[index(level, expected)];
    if (magnitude < symbols) return row[magnitude];
    const auto beyond = static_cast<uint32_t>(magnitude - symbols + 1);
    return row[symbols - 1] + a_bit_more * static_cast<float>(std::bit_width(beyond) - 1);
  }

 private:
  static constexpr int symbols = 16;
  static size_t index(int level, uint32_t expected) {
    return static_cast<size_t>(level) * bucket_count + bucket_of(expected);
  }
  std::vector<std::array<uint32_t, symbols>> counts_;
  std::vector<std::array<float, symbols>> bits_;
};

} // namespace bccsplat
