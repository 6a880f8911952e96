// SPDX-License-Identifier: Apache-2.0
// Looks for a surface along single rays where neighbouring ones met it: what the samples on the edge pixels
// of an isosurface are found by, without sheets.
#pragma once

#include <span>
#include <vector>

#include "shade/surface.h"

namespace bccsplat {

// Sheet numbers from the first to the last that neighbours were hit at.
struct DepthRun {
  double first = 0, last = 0;
};

// A ray through (i, j) of the picture.
struct EdgeRay {
  double i = 0, j = 0;
  double enter = 0, leave = 0;        // sheet numbers that it runs between
  std::span<const DepthRun> nearby{}; // in order; none: nothing is looked for
};

struct EdgeHit {
  uint32_t ray = 0;
  SurfacePoint point;
};

// Returns the first point at which each ray passes the target, relative to the base, or with `all` every one,
// those of a ray in order. What neighbours did not meet in between is not looked for.
[[nodiscard]] std::vector<EdgeHit> trace_edge_rays(const SurfaceField& field, const SheetView& view,
                                                   double target, double tolerance,
                                                   std::span<const EdgeRay> rays, bool all = false);

} // namespace bccsplat
