// SPDX-License-Identifier: Apache-2.0
// Looks for a surface along single rays where neighbouring ones met it: what the samples on the edge pixels
// of an isosurface are found by, without sheets.
#pragma once

#include <span>
#include <vector>

#include "splat/shade/surface.h"

namespace bccsplat {

// Sheet numbers from the first to the last that neighbours were hit at.
struct DepthRun {
  double first = 0, last = 0;
};

// A ray through (i, j) of the picture.
struct EdgeRay {
  double i = 0, j = 0;
  double enter = 0, leave = 0;        // sheet numbers that it runs between
  std::span<const DepthRun> nearby{}; // in order, at least one
};

// Returns for each ray the first point at which it passes the target, relative to the base; its sheet number
// is infinite where there is none near `nearby`. What neighbours did not meet in between is not looked for.
[[nodiscard]] std::vector<SurfacePoint> trace_edge_rays(const SurfaceField& field, const SheetView& view,
                                                        double target, double tolerance,
                                                        std::span<const EdgeRay> rays);

} // namespace bccsplat
