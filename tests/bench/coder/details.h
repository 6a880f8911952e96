// SPDX-License-Identifier: Apache-2.0
// What a chunk keeps beside its coefficients: where it is air, where it is a hole, and corrections of a
// bound.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bccsplat::bench {

// Samples begin .. begin + size - 1 of a slab whose frames are `frame` samples wide, x fastest.
struct DetailBox {
  std::array<int, 3> begin{}, size{}, frame{};
  int frames = 1;
  [[nodiscard]] size_t row(int t, int z, int y) const {
    return ((size_t(t) * frame[2] + begin[2] + z) * frame[1] + begin[1] + y) * frame[0] + begin[0];
  }
};

struct DetailRule {
  bool has_holes = false;
  float air = 0;
  float bound = 0; // of every sample; 0: none
};

// `source` and `restored` are slabs. Holes are what is not finite. Empty where there is nothing to say.
[[nodiscard]] std::vector<std::byte> code_details(const DetailBox& box, const DetailRule& rule,
                                                  std::span<const float> source,
                                                  std::span<const float> restored);
// Makes of restored samples what was coded.
void apply_details(const DetailBox& box, const DetailRule& rule, std::span<const std::byte> bytes,
                   std::span<float> restored);

// Sets 1 where what is coded is exact: air blocks, and holes, whose values do not matter.
void mark_exact(const DetailBox& box, const DetailRule& rule, std::span<const float> source,
                std::span<uint8_t> exact);

} // namespace bccsplat::bench
