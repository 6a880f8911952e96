// SPDX-License-Identifier: Apache-2.0
#include "points/brick.h"

#include <algorithm>
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

BrickLayer layer_from_dense(const Lattice3& lattice, int coset, std::span<const float> dense) {
  BrickLayer layer(lattice, coset);
  const Int3 n = layer.dims();
  for (size_t s = 0; s < layer.brick_slots(); ++s) {
    const Int3 b = layer.slot_position(s);
    auto brick = std::make_shared<Brick>();
    for (int z = 0; z < std::min(brick_edge, n[2] - b[2] * brick_edge); ++z)
      for (int y = 0; y < std::min(brick_edge, n[1] - b[1] * brick_edge); ++y) {
        const int width = std::min(brick_edge, n[0] - b[0] * brick_edge);
        const auto from =
            (static_cast<size_t>(b[2] * brick_edge + z) * n[1] + (b[1] * brick_edge + y)) * n[0] +
            b[0] * brick_edge;
        std::copy_n(dense.begin() + from, width, brick->value.begin() + (z * brick_edge + y) * brick_edge);
      }
    if (brick->keep_above(0) > 0) layer.set(s, std::move(brick));
  }
  return layer;
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
