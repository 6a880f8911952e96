// SPDX-License-Identifier: Apache-2.0
// Tells whether a point of space falls on missing data: the nearest site, of either coset, decides.
#pragma once

#include <array>

#include "base/vec.h"
#include "points/brick.h"

namespace bccsplat {

// layers: one per coset (a CC lattice has one); p in lattice units, inside the domain.
[[nodiscard]] bool is_hole_at(std::array<const BrickLayer*, 2> layers, const Vec3& p);

} // namespace bccsplat
