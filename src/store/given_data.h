// SPDX-License-Identifier: Apache-2.0
// What a writer has been given of its series so far.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace bccsplat {

struct GivenData {
  enum class Kind : uint8_t { none, frames, layers };
  Kind kind = Kind::none;
  std::vector<uint64_t> added; // frames or layers, by channel
  std::vector<double> times;   // of the frames

  [[nodiscard]] bool has_frames() const { return kind == Kind::frames; }
  // Returns how many every channel has.
  [[nodiscard]] uint64_t least() const { return *std::min_element(added.begin(), added.end()); }
};

} // namespace bccsplat
