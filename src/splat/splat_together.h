// SPDX-License-Identifier: Apache-2.0
// Several objects in one picture, which go through the sheets side by side, front to back: a slice and what
// moved, which is 3.5D motion blur (Neophytou & Mueller 2002, section 4.3), or several slices.
#pragma once

#include <functional>
#include <span>

#include "base/context.h"
#include "draw/stats.h"
#include "draw/tile_pixels.h"
#include "splat/plan/scene.h"

namespace bccsplat {

// Draws in modes composite and isosurface; the mode is the slice's, and the trail is always composited.
// Sources share the slice's camera and sheets: their views differ by a translation of lattice space at most.
DrawStats splat_with_trail(const SplatObject& object, const SplatOptions& options, const Context& context,
                           const std::function<void(const TilePixels&)>& emit);

// Draws objects in mode composite into one picture, as far as each is in its own domain: slice and trail of
// each are joined by its rule, and what the objects absorb adds. Their views and those of what they are
// painted by have the same pixels and sheets.
DrawStats splat_together(std::span<const SplatObject> scenes, const SplatOptions& options,
                         const Context& context, const std::function<void(const TilePixels&)>& emit);

} // namespace bccsplat
