// 3.5D motion blur (Neophytou & Mueller 2002, section 4.3): a slice and what moved, drawn into one picture.
// The trail is a set of slices, each with its classes and its share of the whole.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "splat/splat.h"
#include "splat/stack.h"

namespace bccsplat {

struct TrailPart {
  SplatScene scene; // the view is that of the slice
  float weight = 1; // of its extinction; the parts of a trail sum to 1
};

// Modes composite and isosurface (of the slice; the trail is always composited). Every object is drawn in
// full: nothing is skipped for what another one hides.
SplatStats splat_with_trail(const SplatScene& slice, std::span<const TrailPart> trail, TrailCombine combine,
                            const SplatOptions& options, const Context& context,
                            const std::function<void(const TilePixels&)>& emit);

} // namespace bccsplat
