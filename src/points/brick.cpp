// SPDX-License-Identifier: Apache-2.0
#include "points/brick.h"

#include <bit>
#include <cmath>

namespace bccsplat {

int Brick::count() const {
  int n = 0;
  for (const uint16_t row : kept) n += std::popcount(row);
  return n;
}

int Brick::keep_above(float threshold) {
  int n = 0;
  for (size_t r = 0; r < brick_rows; ++r) {
    uint16_t bits = 0;
    for (size_t x = 0; x < brick_edge; ++x) {
      float& v = value[r * brick_edge + x];
      if (std::fabs(v) > threshold)
        bits = static_cast<uint16_t>(bits | 1u << x);
      else
        v = 0;
    }
    kept[r] = bits;
    n += std::popcount(bits);
  }
  return n;
}

int64_t BrickLayer::kept_sites() const {
  int64_t n = 0;
  for_bricks([&](const auto& brick) { n += brick->count(); });
  return n;
}

uint64_t BrickLayer::bytes() const {
  uint64_t n = own_bytes();
  for_bricks([&](const auto& brick) { n += sizeof(Brick) + (brick->hole ? sizeof(BrickMask) : 0); });
  return n;
}

std::vector<float> layer_to_dense(const BrickLayer& layer) {
  const Int3 n = layer.dims();
  std::vector<float> dense;
  dense.reserve(static_cast<size_t>(n[0]) * n[1] * n[2]);
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) dense.push_back(layer.value(x, y, z));
  return dense;
}

} // namespace bccsplat
