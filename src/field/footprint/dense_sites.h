// SPDX-License-Identifier: Apache-2.0
// Copies of the sites around a batch of points: where points lie close together, copying a box once is
// cheaper than finding bricks and mirrors for each.
#pragma once

#include <array>
#include <span>

#include "field/footprint/footprint.h"
#include "points/brick.h"

namespace bccsplat {

// Sites origin .. origin + size - 1 of a coset, which may lie beyond its ends.
struct SiteBox {
  static constexpr int max_length = 512, max_rows = 64; // along an axis; of DenseScratch along y and z
  Int3 origin{}, size{};
};

// Copies a box of a layer, mirrored beyond the ends, x fastest without gaps. False when all of it is air.
bool gather_box(const BrickLayer& layer, const SiteBox& box, float* out);

// One coset's copy at one instant: the sum of the layers weighted in time, and behind it where slopes are
// wanted the sum weighted by the slopes in time.
struct DenseSites {
  SiteBox box;
  size_t row = 0, plane = 0, layer = 0; // floats from one to the next
  bool air = true;                      // all of it; then nothing is copied
  float* value = nullptr;
};

struct DenseScratch {
  static constexpr size_t capacity = 14336; // floats, 56 KiB: more would leave the fast caches
  std::array<DenseSites, 2> sites;
  float* single = nullptr; // room for one layer of the larger box
  alignas(64) std::array<float, capacity> floats;

  // Lays the copies out. False when copying would cost more than it saves, or room is short.
  bool reserve(const FootprintPlan& plan, const std::array<SiteBox, 2>& box, size_t points, bool slopes);
};

} // namespace bccsplat
