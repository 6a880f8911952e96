// SPDX-License-Identifier: Apache-2.0
// 3.5D motion blur (Neophytou & Mueller 2002, section 4.3): a slice and what moved, drawn into one picture.
// All objects go through the sheets side by side, front to back.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "draw/stats.h"
#include "draw/tile_pixels.h"
#include "splat/plan/scene.h"
#include "splat/trail/matter.h"

namespace bccsplat {

// A moment of a trail with its table; see ShotStill.
struct TrailStill {
  std::span<const SheetShare> shares;
  const ClassTable* table = nullptr;
  float weight = 1;
  double frame = 0;
  std::optional<uint32_t> paint{}; // a source whose values say the colours; none: the still's own
  bool lit = true;                 // where the picture is
  // What it is composited with: group 1 by itself, or one of the two of a pair (see TrailJob).
  size_t group = 1;
};

// A slice, alone or among others in one picture, with its trail.
struct SplatObject {
  SplatScene scene;
  std::vector<SplatScene> sources{}; // of the trail; none: it has none
  std::vector<TrailStill> stills{};
  TrailCombine combine = TrailCombine::physical; // of slice and trail; among others not post
};

// Draws in modes composite and isosurface; the mode is the slice's, and the trail is always composited.
// Sources share the slice's camera and sheets: their views differ by a translation of lattice space at most.
// A source's table must let everything be seen that a still made of it shows (bricks are left out by it).
DrawStats splat_with_trail(const SplatObject& object, const SplatOptions& options, const Context& context,
                           const std::function<void(const TilePixels&)>& emit);

// Draws objects in mode composite into one picture, as far as each is in its own domain: slice and trail of
// each are joined by its rule, and what the objects absorb adds. Their views and those of what they are
// painted by have the same pixels and sheets.
DrawStats splat_together(std::span<const SplatObject> scenes, const SplatOptions& options,
                         const Context& context, const std::function<void(const TilePixels&)>& emit);

} // namespace bccsplat
