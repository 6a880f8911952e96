// SPDX-License-Identifier: Apache-2.0
// What several objects in one space absorb and emit on one sheet of a tile, and how it is composited.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "draw/shot.h"
#include "splat/sheet/sheet.h"

namespace bccsplat {

// Planes of a tile's pixels, pitched as the sheet's: optical depth of the segment along the pixel's ray, and
// shaded colour, value and frame index times it, summed over the objects of a group.
struct MatterPlanes {
  float *red = nullptr, *green = nullptr, *blue = nullptr, *depth = nullptr;
  float *value = nullptr, *time = nullptr; // null: not asked for
};

struct JoinArgs {
  float k = 0, front = 0.5f; // as of SheetArgs
  int width = 0, height = 0, pitch = 0;
  std::array<const MatterPlanes*, 2> group{}; // the slice's, the trail's; null: nothing on this sheet
  TrailCombine combine = TrailCombine::physical;
  float stop = 1, depth_at = 0.5f; // as of SheetClasses
  PixelPlanes pixel;
};

// Makes one group of an object's two, a slice and its trail, as the rule joins them: added to `into`, whose
// extinctions then add to those of other objects. Planes are pitched as those of JoinArgs.
struct MatterPair {
  int width = 0, height = 0, pitch = 0;
  std::array<const MatterPlanes*, 2> group{}; // null: nothing on this sheet
  TrailCombine combine = TrailCombine::interleaved;
};
void pair_up(const MatterPair& pair, const MatterPlanes& into);

// out = sum of weight[i] * plane[i], `width` x `height` values at rows of `pitch` floats (whole vectors are
// read and written); range: smallest and largest of what was written.
struct MixArgs {
  std::span<const float* const> plane;
  std::span<const float> weight;
  float* out = nullptr;
  int width = 0, height = 0, pitch = 0;
};

struct MatterLoops {
  // Adds an object's finished sheet, its extinction times `weight`, where pixels are still open.
  void (*absorb)(const SheetArgs&, float weight, const MatterPlanes& out);
  // Composites a sheet; returns the number of pixels that closed.
  int (*join)(const JoinArgs&);
  std::array<float, 2> (*mix)(const MixArgs&);
};

[[nodiscard]] const MatterLoops& reference_matter_loops();
[[nodiscard]] const MatterLoops& simd_matter_loops(); // best target of this machine

} // namespace bccsplat
