// SPDX-License-Identifier: Apache-2.0
#include "motion/box.h"

#include <algorithm>
#include <array>
#include <utility>

namespace bccsplat::motion {
namespace {

constexpr int32_t shortest_to_reduce = 32; // of the first two halvings
constexpr int32_t shortest_to_match = 16;  // of the others

Level halved(const Level& level, int32_t shortest) {
  Level half = level;
  for (size_t a = 0; a < 3; ++a)
    if (half.box.dims[a] >= shortest) half.box = halved(half.box, a), half.factor[a] *= 2;
  return half;
}

} // namespace

Box halved(const Box& box, size_t axis) {
  constexpr std::array<float, 5> weights{1 / 16.f, 4 / 16.f, 6 / 16.f, 4 / 16.f, 1 / 16.f};
  const int32_t n = box.dims[axis];
  Box half{box.dims, {}};
  half.dims[axis] = (n + 1) / 2;
  size_t inner = 1, outer = 1;
  for (size_t a = 0; a < axis; ++a) inner *= box.dims[a];
  for (size_t a = axis + 1; a < 3; ++a) outer *= box.dims[a];
  half.values.assign(inner * outer * half.dims[axis], 0);
  for (size_t o = 0; o < outer; ++o)
    for (int32_t i = 0; i < half.dims[axis]; ++i) {
      float* const to = half.values.data() + (o * half.dims[axis] + i) * inner;
      for (int32_t k = 0; k < 5; ++k) {
        const int32_t at = std::clamp(2 * i + k - 2, 0, n - 1);
        const float* const from = box.values.data() + (o * n + at) * inner;
        for (size_t j = 0; j < inner; ++j) to[j] += weights[k] * from[j];
      }
    }
  return half;
}

std::vector<Level> make_pyramid(const Box& frame) {
  const Level half = halved(Level{frame, {1, 1, 1}}, shortest_to_reduce);
  std::vector<Level> levels{halved(half, shortest_to_reduce)};
  while (true) {
    Level next = halved(levels.back(), shortest_to_match);
    if (next.factor == levels.back().factor) return levels;
    levels.push_back(std::move(next));
  }
}

} // namespace bccsplat::motion
