// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/dense_moment.h"

#include <vector>

namespace bccsplat::motion {
namespace {

// The flow and the mask along a row of nodes, between the rows around a line of samples.
struct NodeRow {
  std::vector<Float3> velocity;
  std::vector<float> mask;
  bool any = false; // mask above 0

  NodeRow(const Flow& flow, std::span<const float> given, int32_t y, int32_t z)
      : velocity(flow.nodes.dims[0]), mask(flow.nodes.dims[0]) {
    const Between by = between(flow.nodes, 1, static_cast<float>(y));
    const Between bz = between(flow.nodes, 2, static_cast<float>(z));
    for (int32_t x = 0; x < flow.nodes.dims[0]; ++x)
      for (const int corner : {0, 1, 2, 3}) {
        const bool second_y = corner & 1, second_z = corner & 2;
        const float share = (second_y ? by.share : 1 - by.share) * (second_z ? bz.share : 1 - bz.share);
        const size_t i =
            flow.nodes.index({x, second_y ? by.second : by.first, second_z ? bz.second : bz.first});
        for (size_t a = 0; a < 3; ++a) velocity[x][a] += share * flow.velocity[i][a];
        mask[x] += share * (given.empty() ? 1 : given[i]);
        any = any || mask[x] > 0;
      }
  }
};

} // namespace

Box sum_along(const Ways& ways, const Flow& flow, std::span<const float> mask, const Box& still) {
  Box moment = still;
  for (int32_t z = 0; z < still.dims[2]; ++z)
    for (int32_t y = 0; y < still.dims[1]; ++y) {
      const NodeRow row(flow, mask, y, z);
      if (!row.any) continue;
      float* const out = moment.values.data() + moment.index(0, y, z);
      for (int32_t x = 0; x < still.dims[0]; ++x) {
        const Between b = between(flow.nodes, 0, static_cast<float>(x));
        const float on = (1 - b.share) * row.mask[b.first] + b.share * row.mask[b.second];
        if (on <= 0) continue;
        Float3 v;
        for (size_t a = 0; a < 3; ++a)
          v[a] = (1 - b.share) * row.velocity[b.first][a] + b.share * row.velocity[b.second][a];
        const Float3 place{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        out[x] += on * (ways.value(place, v) - out[x]);
      }
    }
  return moment;
}

Box dense_moment(Finder& finder, double time, const Box& still, const SumOptions& options) {
  const std::vector<double>& times = finder.times();
  const size_t i = interval_of(times, time);
  const auto here = finder.interval(i);
  const std::vector<Share> shares = options.cubic ? cubic_shares(times, time) : linear_shares(times, time);
  std::vector<const Spline*> frames(times.size());
  for (const Share& s : shares) frames[s.frame] = &finder.spline(s.frame);
  return sum_along(Ways(here->flow, frames, shares, before_middle(times, time)), here->flow,
                   options.gated ? std::span<const float>(here->mask) : std::span<const float>(), still);
}

} // namespace bccsplat::motion
