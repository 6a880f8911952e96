// SPDX-License-Identifier: Apache-2.0
#include "motion/gate.h"

#include <algorithm>
#include <cmath>

#include "motion/warped.h"

namespace bccsplat::motion {
namespace {

constexpr int32_t apart = 2;      // of the samples that are looked at, along each axis
constexpr float rounding = 1e-6f; // of the largest value: what is predicted to within it stands
constexpr float soft_price = 3;   // of a difference along the flow, beside one where things stand

// body(place, nodes around it, velocity there).
template<class Body> void for_each_looked_at(const Flow& flow, const Int3& dims, const Body& body) {
  for (int32_t z = 0; z < dims[2]; z += apart)
    for (int32_t y = 0; y < dims[1]; y += apart)
      for (int32_t x = 0; x < dims[0]; x += apart) {
        const Float3 place{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        const Corners c = corners(flow.nodes, place);
        Float3 v{};
        for (size_t k = 0; k < 8; ++k)
          for (size_t a = 0; a < 3; ++a) v[a] += c.share[k] * flow.velocity[c.node[k]][a];
        body(place, c, v);
      }
}

} // namespace

Trial try_frame(const Flow& flow, std::span<const Spline* const> frames, const std::vector<Share>& shares,
                float halfway, const Box& left_out) {
  Trial trial{std::vector<float>(flow.nodes.count()), std::vector<float>(flow.nodes.count())};
  const Ways ways(flow, frames, shares, halfway);
  float largest = 0;
  for (const float v : left_out.values) largest = std::max(largest, std::abs(v));
  const float unseen = std::pow(rounding * largest, 2.f);
  for_each_looked_at(flow, left_out.dims, [&](const Float3& place, const Corners& c, const Float3& v) {
    const float truth = left_out.values[left_out.index(
        static_cast<int32_t>(place[0]), static_cast<int32_t>(place[1]), static_cast<int32_t>(place[2]))];
    float still = -truth;
    for (const Share& s : shares) still += s.weight * frames[s.frame]->value(place);
    const float moved = ways.value(place, v) - truth;
    for (size_t k = 0; k < 8; ++k) {
      trial.still[c.node[k]] += c.share[k] * still * still;
      trial.moved[c.node[k]] += c.share[k] * (moved * moved + unseen);
    }
  });
  return trial;
}

std::vector<float> gate(std::span<const Trial* const> trials, float theta) {
  std::vector<float> mask(trials.front()->still.size());
  for (const Trial* t : trials)
    for (size_t i = 0; i < mask.size(); ++i)
      if (t->moved[i] < theta * theta * t->still[i]) mask[i] += 1 / static_cast<float>(trials.size());
  return mask;
}

Trial try_interval(const Flow& flow, const Spline& first, const Spline& second) {
  Trial trial{std::vector<float>(flow.nodes.count()), std::vector<float>(flow.nodes.count())};
  for_each_looked_at(flow, first.dims(), [&](const Float3& place, const Corners& c, const Float3& v) {
    Float3 before, after;
    for (size_t a = 0; a < 3; ++a) before[a] = place[a] - v[a] / 2, after[a] = place[a] + v[a] / 2;
    const float still = second.value(place) - first.value(place);
    const float moved = second.value(after) - first.value(before);
    for (size_t k = 0; k < 8; ++k) {
      trial.still[c.node[k]] += c.share[k] * still * still;
      trial.moved[c.node[k]] += c.share[k] * moved * moved;
    }
  });
  return trial;
}

std::vector<float> soft_mask(const Trial& interval) {
  std::vector<float> mask(interval.still.size());
  for (size_t i = 0; i < mask.size(); ++i) {
    const float still = interval.still[i];
    mask[i] = still > 0 ? still / (still + soft_price * interval.moved[i]) : 0;
  }
  return mask;
}

} // namespace bccsplat::motion
