// SPDX-License-Identifier: Apache-2.0
// Smooth edges of an isosurface: pixels where neighbouring ones meet another surface, or none, get the mean
// of four samples within them, all others stay as they are.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "base/context.h"
#include "splat/plan/scene.h"

namespace bccsplat {

// What the pixel centres of a picture met: sheet numbers, infinite where nothing is.
struct SurfaceDepths {
  int width = 0, height = 0;
  std::vector<float> k; // row by row

  [[nodiscard]] float at(int i, int j) const {
    return k[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
  }
};

struct EdgeStats {
  uint64_t pixels = 0; // on edges
  double ms = 0;       // summed over threads
};

// Calls `emit` once for each edge pixel, from any thread: premultiplied by the share of its samples that a
// surface covers.
EdgeStats smooth_edges(const SplatScene& scene, const SplatOptions& options, const SurfaceDepths& depths,
                       const Context& context,
                       const std::function<void(int i, int j, const std::array<float, 4>& rgba)>& emit);

} // namespace bccsplat
