// SPDX-License-Identifier: Apache-2.0
#include "motion/occupied.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bccsplat::motion {
namespace {

// Marks the neighbours of what is marked along an axis.
void widen(std::vector<uint8_t>& any, const Int3& dims, size_t axis) {
  size_t stride = 1;
  for (size_t a = 0; a < axis; ++a) stride *= static_cast<size_t>(dims[a]);
  const auto n = static_cast<size_t>(dims[axis]);
  const std::vector<uint8_t> narrow = any;
  for (size_t i = 0; i < any.size(); ++i) {
    if (!narrow[i]) continue;
    const size_t at = i / stride % n;
    if (at > 0) any[i - stride] = 1;
    if (at + 1 < n) any[i + stride] = 1;
  }
}

} // namespace

Occupied::Blocks Occupied::blocks_of(const BrickLayer& layer, float nothing) {
  constexpr int32_t in_brick = brick_edge / edge;
  Blocks blocks;
  size_t count = 1;
  for (size_t a = 0; a < 3; ++a) {
    blocks.dims[a] = layer.brick_dims()[a] * in_brick;
    count *= static_cast<size_t>(blocks.dims[a]);
  }
  blocks.any.resize(count);
  for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
    const Brick* const brick = layer.brick(slot);
    if (!brick) continue;
    const Int3 first = layer.slot_position(slot);
    for (int32_t site = 0; site < brick_sites; ++site) {
      if (std::abs(brick->value[static_cast<size_t>(site)]) <= nothing) continue;
      const int32_t x = first[0] * in_brick + site % brick_edge / edge,
                    y = first[1] * in_brick + site / brick_edge % brick_edge / edge,
                    z = first[2] * in_brick + site / brick_rows / edge;
      blocks.any[blocks.index({x, y, z})] = 1;
    }
  }
  for (size_t a = 0; a < 3; ++a) widen(blocks.any, blocks.dims, a);
  return blocks;
}

bool Occupied::within(const Vec3& low, const Vec3& high) const {
  for (const Blocks& b : cosets_) {
    const Int3 first = block(b, low), last = block(b, high);
    for (int32_t z = first[2]; z <= last[2]; ++z)
      for (int32_t y = first[1]; y <= last[1]; ++y)
        for (int32_t x = first[0]; x <= last[0]; ++x)
          if (b.any[b.index({x, y, z})]) return true;
  }
  return false;
}

Occupied::Occupied(const Slice& slice, float nothing) {
  per_block_ = 1 / (edge * slice.lattice.plane_distance() * (slice.lattice.bcc ? 2 : 1));
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    Blocks blocks = slice.lattice.any_periodic()
                        ? Blocks{{1, 1, 1}, 0, {1}}
                        : blocks_of(std::as_const(slice).coset[static_cast<size_t>(c)], nothing);
    blocks.before = -.5 * c / edge;
    cosets_.push_back(std::move(blocks));
  }
}

} // namespace bccsplat::motion
