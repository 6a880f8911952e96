// SPDX-License-Identifier: Apache-2.0
// A host's depth plane as the ends of rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "view/sight.h"

namespace bccsplat {

enum class DepthKind : uint8_t {
  planar, // distance along the view direction
  ray,    // distance along the pixel's ray
  device  // what a depth buffer holds
};

struct HostPlane {
  const float* pixels = nullptr; // null: none
  std::ptrdiff_t row_floats = 0; // from a row to the next, any sign; 0: packed

  // width: of the plane; components: floats of a pixel.
  [[nodiscard]] const float* row(int y, int width, int components) const {
    return pixels + y * (row_floats != 0 ? row_floats : static_cast<std::ptrdiff_t>(width) * components);
  }
};

// Returns planar distances, packed; infinity where nothing is: NaN, infinity, and of device depths the far
// end.
[[nodiscard]] std::vector<float> ray_ends(const HostPlane& depth, DepthKind kind, const DeviceDepth& device,
                                          bool reversed, const Sight& sight, int width, int height);

} // namespace bccsplat
