// SPDX-License-Identifier: Apache-2.0
// The sites of one coset around a point.
#pragma once

#include "points/brick.h"

namespace bccsplat {

// No kernel reaches further than two pitches: at most 4 sites of a coset per axis lie strictly within.
inline constexpr int patch_edge = 4;
inline constexpr int patch_rows = patch_edge * patch_edge;
inline constexpr int patch_sites = patch_edge * patch_rows;

// The values of a brick that is not there.
[[nodiscard]] const float* air_brick();

// Distance of neighbouring sites of a coset in lattice units.
[[nodiscard]] inline double coset_pitch(const Lattice3& lattice) {
  return lattice.bcc ? 2 * lattice.plane_distance() : lattice.plane_distance();
}

} // namespace bccsplat
