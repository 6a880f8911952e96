// SPDX-License-Identifier: Apache-2.0
// 3.5D motion blur (Neophytou & Mueller 2002, section 4.3): a slice and what moved, drawn into one picture.
// All objects go through the sheets side by side, front to back.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "splat/splat.h"
#include "splat/trail/matter.h"

namespace bccsplat {

struct SheetShare {
  uint32_t source = 0;
  float weight = 1;
};

// One moment of a trail: its field is a weighted sum of sources. Where there are several shares, the sources
// are time slices of one lattice and `frame` is the moment's; one share is the source alone, with weight 1
// and its own time.
struct TrailStill {
  std::vector<SheetShare> shares;
  const ClassTable* table = nullptr;
  float weight = 1; // of its extinction; those of a trail sum to 1
  double frame = 0;
};

// Draws in modes composite and isosurface; the mode is the slice's, and the trail is always composited.
// Sources share the slice's camera and sheets: their views differ by a translation of lattice space at most.
// A source's table must let everything be seen that a still made of it shows (bricks are left out by it).
SplatStats splat_with_trail(const SplatScene& slice, std::span<const SplatScene> sources,
                            std::span<const TrailStill> stills, TrailCombine combine,
                            const SplatOptions& options, const Context& context,
                            const std::function<void(const TilePixels&)>& emit);

} // namespace bccsplat
