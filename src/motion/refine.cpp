// SPDX-License-Identifier: Apache-2.0
#include "motion/refine.h"

#include <algorithm>
#include <cmath>

#include "motion/normal_equations.h"

namespace bccsplat::motion {
namespace {

constexpr float longest = 1;      // step, in samples of the level
constexpr int32_t long_axis = 16; // samples

bool inside(const Float3& place, const Int3& dims) {
  for (size_t a = 0; a < 3; ++a)
    if (place[a] < 0 || place[a] > static_cast<float>(dims[a] - 1)) return false;
  return true;
}

// What the samples of a level see, those that lie in both frames.
std::vector<Sight> look(const Flow& flow, const Spline& first, const Spline& second, const Int3& factor) {
  std::vector<Sight> sights;
  const Int3& n = first.dims();
  Int3 step; // of those that are looked at: nodes are as far apart along axes that were not reduced
  for (size_t a = 0; a < 3; ++a) step[a] = factor[a] == 1 && n[a] >= long_axis ? 2 : 1;
  for (int32_t z = 0; z < n[2]; z += step[2])
    for (int32_t y = 0; y < n[1]; y += step[1])
      for (int32_t x = 0; x < n[0]; x += step[0]) {
        const Int3 at{x, y, z};
        Float3 place, before, after;
        for (size_t a = 0; a < 3; ++a) place[a] = static_cast<float>(at[a] * factor[a]);
        Sight s{corners(flow.nodes, place), {}, 0};
        for (size_t a = 0; a < 3; ++a) {
          float v = 0;
          for (size_t k = 0; k < 8; ++k) v += s.corners.share[k] * flow.velocity[s.corners.node[k]][a];
          const float half = v / static_cast<float>(2 * factor[a]);
          before[a] = static_cast<float>(at[a]) - half, after[a] = static_cast<float>(at[a]) + half;
        }
        if (!inside(before, n) || !inside(after, n)) continue;
        Float3 g, h;
        const float v0 = first.value_and_gradient(before, g), v1 = second.value_and_gradient(after, h);
        s.difference = v1 - v0;
        for (size_t a = 0; a < 3; ++a) s.slope[a] = (g[a] + h[a]) / static_cast<float>(2 * factor[a]);
        if (s.slope != Float3{}) sights.push_back(s);
      }
  return sights;
}

} // namespace

void refine(Flow& flow, const Spline& first, const Spline& second, const Int3& factor,
            const RefineOptions& options) {
  for (int32_t step = 0; step < options.steps; ++step) {
    const std::vector<Sight> sights = look(flow, first, second, factor);
    const std::vector<Float3> change = better_by(flow, sights, options.smoothness);
    for (size_t i = 0; i < change.size(); ++i)
      for (size_t a = 0; a < 3; ++a) {
        const float most = longest * static_cast<float>(factor[a]);
        flow.velocity[i][a] += std::clamp(change[i][a], -most, most);
      }
  }
}

} // namespace bccsplat::motion
