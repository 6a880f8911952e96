// SPDX-License-Identifier: Apache-2.0
#include "view/host_depth.h"

#include <cmath>
#include <limits>

#include "base/grid.h"

namespace bccsplat {

std::vector<float> ray_ends(const HostPlane& depth, DepthKind kind, const DeviceDepth& device, bool reversed,
                            const Sight& sight, int width, int height) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  std::vector<float> ends(plane_size(width, height));
  for (int y = 0; y < height; ++y) {
    const float* const in = depth.row(y, width, 1);
    float* const out = ends.data() + plane_index(0, y, width);
    for (int x = 0; x < width; ++x) {
      const float d = in[x];
      if (std::isnan(d))
        out[x] = infinite;
      else if (kind == DepthKind::device)
        out[x] = (reversed ? d <= 0 : d >= 1) ? infinite : static_cast<float>(device.distance(d));
      else if (kind == DepthKind::ray && sight.perspective)
        out[x] = d / static_cast<float>(length(sight.corner + (x * sight.across + y * sight.down)));
      else
        out[x] = d;
    }
  }
  return ends;
}

} // namespace bccsplat
