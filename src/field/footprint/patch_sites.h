// SPDX-License-Identifier: Apache-2.0
// Finds the sites of a patch in memory: in one brick, or copied where bricks or mirrors meet.
#pragma once

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "field/footprint/footprint.h"
#include "field/footprint/patch.h"

namespace bccsplat {

// The sites of one coset around a point in the layers around an instant: site (x, y, z) of layer k at
// corner[k] + z * plane + y * row + x. Rows may be read 4 sites long, whatever the plan's edge.
struct PatchSites {
  int layers = 0; // those that are not air throughout
  std::array<const float*, max_stack> corner;
  std::array<size_t, max_stack> place; // of each: which layer in reach it is, from 0
  size_t row = brick_edge, plane = brick_rows;
  std::array<int32_t, 4> first{INT32_MIN}; // what was looked up last: first site and layer
  alignas(64) std::array<std::array<float, 2 * patch_sites>, max_stack> copy; // rows of 8
};

// Copies the sites of a patch, mirrored beyond the ends.
void copy_patch(const FootprintPlan& plan, const FootprintPlan::Coset& coset, PatchSites& patch);

// first: the site (x, y, z) strictly within the kernel's radius and the layer strictly within its reach
// where both begin; they may lie beyond the ends.
inline void find_patch(const FootprintPlan& plan, const FootprintPlan::Coset& coset,
                       const std::array<int32_t, 4>& first, PatchSites& patch) {
  if (first == patch.first) return;
  patch.first = first;
  patch.layers = 0;
  // A sign bit: a site below 0, one at or beyond the end, or one beyond the brick's end.
  int crossing = 0;
  for (size_t a = 0; a < 3; ++a) {
    const int read = a == 0 ? patch_edge : plan.edge;
    crossing |= first[a] | (coset.dims[a] - plan.edge - first[a]) |
                (brick_edge - read - (first[a] & (brick_edge - 1)));
  }
  if (crossing < 0) {
    copy_patch(plan, coset, patch);
    return;
  }
  patch.row = brick_edge, patch.plane = brick_rows;
  const auto of = [&](size_t a) { return static_cast<size_t>(first[a]) / brick_edge; };
  const auto in = [&](size_t a) { return static_cast<size_t>(first[a]) % brick_edge; };
  const auto bricks = [&](size_t a) { return static_cast<size_t>(coset.brick_dims[a]); };
  const size_t slot = (of(2) * bricks(1) + of(1)) * bricks(0) + of(0);
  const size_t offset = (in(2) * brick_edge + in(1)) * brick_edge + in(0);
  for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) {
    const auto layer = first[3] + k; // wraps round below 0
    if (layer >= coset.bricks.size()) continue;
    const Brick* brick = coset.bricks[layer][slot].get();
    if (!brick) continue;
    const size_t at = patch.layers++;
    patch.corner[at] = brick->value.data() + offset;
    patch.place[at] = k;
  }
}

// Asks the memory for the sites that find_patch will point to soon; those in other bricks are left out.
inline void fetch_patch(const FootprintPlan& plan, const FootprintPlan::Coset& coset,
                        const std::array<int32_t, 4>& first) {
  std::array<size_t, 3> brick, begin, end; // in the brick
  for (size_t a = 0; a < 3; ++a) {
    const int at = std::clamp(first[a], 0, coset.dims[a] - 1);
    brick[a] = at / brick_edge, begin[a] = at % brick_edge;
    end[a] = std::min<size_t>(begin[a] + plan.edge, brick_edge);
  }
  const auto bricks = [&](size_t a) { return static_cast<size_t>(coset.brick_dims[a]); };
  const size_t slot = (brick[2] * bricks(1) + brick[1]) * bricks(0) + brick[0];
  for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) {
    const auto layer = first[3] + k; // wraps round below 0
    if (layer >= coset.bricks.size()) continue;
    const Brick* from = coset.bricks[layer][slot].get();
    if (!from) continue;
    for (size_t z = begin[2]; z < end[2]; ++z)
      for (size_t y = begin[1]; y < end[1]; ++y) // a row is a line of the cache
        hwy::Prefetch(from->value.data() + (z * brick_edge + y) * brick_edge);
  }
}

} // namespace bccsplat
