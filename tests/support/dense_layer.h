// SPDX-License-Identifier: Apache-2.0
// One layer of a dense array as bricks.
#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include "points/brick.h"

namespace bccsplat::test {

// `dense` has dims() sites, x fastest; values of 0 are not kept.
[[nodiscard]] inline BrickLayer layer_from_dense(const Lattice3& lattice, int coset,
                                                 std::span<const float> dense) {
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

} // namespace bccsplat::test
