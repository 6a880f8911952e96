// SPDX-License-Identifier: Apache-2.0
#include "points/crop.h"

#include <algorithm>

namespace bccsplat {
namespace {

// Copies sites x .. x + count of a row of `from` to `site` and on of a brick.
void copy_row(const BrickLayer& from, const Int3& at, int count, int site, Brick& to) {
  for (int i = 0; i < count; ++i) {
    const int x = at[0] + i;
    const Brick* brick = from.brick(x / brick_edge, at[1] / brick_edge, at[2] / brick_edge);
    if (!brick) continue;
    const int s = (at[2] % brick_edge * brick_edge + at[1] % brick_edge) * brick_edge + x % brick_edge;
    const size_t row = site / brick_edge;
    const auto bit = static_cast<uint16_t>(1u << ((site + i) % brick_edge));
    to.value[site + i] = brick->value[s];
    if (brick->kept[s / brick_edge] >> (s % brick_edge) & 1)
      to.kept[row] = static_cast<uint16_t>(to.kept[row] | bit);
    if (!brick->is_hole(s)) continue;
    if (!to.hole) to.hole = std::make_unique<BrickMask>();
    (*to.hole)[row] = static_cast<uint16_t>((*to.hole)[row] | bit);
  }
}

} // namespace

BrickLayer crop_layer(const BrickLayer& layer, const Lattice3& lattice, const Int3& first) {
  BrickLayer out(lattice, layer.coset());
  const Int3& n = out.dims();
  for (size_t slot = 0; slot < out.brick_slots(); ++slot) {
    const Int3 b = out.slot_position(slot);
    auto brick = std::make_shared<Brick>();
    for (int z = b[2] * brick_edge; z < std::min(n[2], (b[2] + 1) * brick_edge); ++z)
      for (int y = b[1] * brick_edge; y < std::min(n[1], (b[1] + 1) * brick_edge); ++y) {
        const int x = b[0] * brick_edge;
        copy_row(layer, {x + first[0], y + first[1], z + first[2]}, std::min(brick_edge, n[0] - x),
                 (z % brick_edge * brick_edge + y % brick_edge) * brick_edge, *brick);
      }
    const bool any = brick->hole || std::any_of(brick->kept.begin(), brick->kept.end(),
                                                [](uint16_t row) { return row != 0; });
    if (any) out.set(slot, std::move(brick));
  }
  return out;
}

} // namespace bccsplat
