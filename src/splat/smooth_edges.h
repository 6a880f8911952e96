// SPDX-License-Identifier: Apache-2.0
// Smooth edges of an isosurface: pixels where neighbouring ones meet another surface, or none, get the mean
// of four samples within them, all others stay as they are.
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.h"
#include "splat/plan/scene.h"

namespace bccsplat {

// A picture of one sample per pixel.
struct SurfacePicture {
  int width = 0, height = 0;
  std::vector<float> k;  // what pixel centres met, row by row: sheet numbers, infinite where nothing is
  float* rgba = nullptr; // premultiplied
  size_t row_floats = 0; // of rgba

  [[nodiscard]] float depth(int i, int j) const {
    return k[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
  }
  [[nodiscard]] float* color(int i, int j) const {
    return rgba + static_cast<size_t>(j) * row_floats + 4 * static_cast<size_t>(i);
  }
};

struct EdgeStats {
  uint64_t pixels = 0; // on edges
  double ms = 0;       // summed over threads
};

// Draws the edge pixels again: their opacity is the share of their samples that a surface covers.
EdgeStats smooth_edges(const SplatScene& scene, const SplatOptions& options, SurfacePicture& picture,
                       const Context& context);

} // namespace bccsplat
