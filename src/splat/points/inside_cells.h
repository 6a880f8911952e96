// SPDX-License-Identifier: Apache-2.0
// Where a field is known to lie beyond an isosurface, seen from air: no surface is there, and points that
// only such places look at need not be drawn.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/points/points.h"

namespace bccsplat {

struct InsideCells {
  const SplatPoints* points = nullptr;
  std::vector<uint64_t> cells; // per SplatPoints::slot, bits as TransformArgs::cells; empty: nothing is known

  // Returns whether the field is known to lie beyond the surface at a place, lattice units.
  [[nodiscard]] bool contains(const Vec3& p) const;
};

} // namespace bccsplat
