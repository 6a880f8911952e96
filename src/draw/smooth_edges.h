// SPDX-License-Identifier: Apache-2.0
// Smooth edges of an isosurface: pixels where neighbouring ones meet another surface, or none, get the mean
// of four samples within them, all others stay as they are. Where there are several surfaces, or light passes
// them, a pixel is on an edge if any of the surfaces along its ray has one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "base/grid.h"
#include "draw/image.h"
#include "draw/shot.h"
#include "draw/surface_hit.h"

namespace bccsplat {

// A picture of one sample per pixel. `k` tells where pixels met one opaque surface, `first` and `hits` where
// they met others.
struct SurfacePicture {
  int width = 0, height = 0;
  std::vector<float> k;          // row by row: sheet numbers, infinite where nothing is
  std::vector<size_t> first;     // pixel p has hits first[p] .. first[p + 1] - 1, in order along its ray
  std::vector<SurfaceHit> hits;  // of all pixels
  float* rgba = nullptr;         // premultiplied
  std::ptrdiff_t row_floats = 0; // of rgba

  [[nodiscard]] size_t pixel(int i, int j) const { return plane_index(i, j, width); }
  [[nodiscard]] bool layered() const { return !first.empty(); }
  [[nodiscard]] float depth(int i, int j) const { return k[pixel(i, j)]; }
  [[nodiscard]] std::span<const SurfaceHit> layers(int i, int j) const {
    const size_t p = pixel(i, j);
    return std::span(hits).subspan(first[p], first[p + 1] - first[p]);
  }
  [[nodiscard]] float* color(int i, int j) const {
    return rgba + j * row_floats + 4 * static_cast<size_t>(i);
  }
};

// Pixels on either side of one that say whether it is on an edge: the one beside it and, how depths change
// there, the next.
inline constexpr int edge_reach = 2;

struct EdgeStats {
  uint64_t pixels = 0; // on edges
  double ms = 0;       // summed over threads
};

// Draws the edge pixels again: their opacity is the share of their samples that a surface covers. drawn:
// hears of the rows that are done.
EdgeStats smooth_edges(const Shot& shot, SurfacePicture& picture, const Context& context,
                       const PixelsDrawn& drawn = {});

} // namespace bccsplat
