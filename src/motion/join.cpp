// SPDX-License-Identifier: Apache-2.0
#include "motion/join.h"

#include <algorithm>
#include <cmath>

namespace bccsplat::motion {
namespace {

constexpr int32_t rounds = 24; // of filling from neighbours

// Somebody who says with what velocity a node is passed.
struct Vote {
  Float3 velocity;
  float weight;
};

// Hands each match to the nodes around the place where it is halfway.
void cast(const Matches& matches, float direction, std::vector<std::vector<Vote>>& votes) {
  for (size_t i = 0; i < matches.nodes.count(); ++i) {
    if (matches.weight[i] <= 0) continue;
    const Int3 n = matches.nodes.node(i);
    Float3 velocity, place;
    for (size_t a = 0; a < 3; ++a) {
      velocity[a] = direction * matches.moved[i][a];
      place[a] = static_cast<float>(n[a] * matches.nodes.spacing) + matches.moved[i][a] / 2;
    }
    const Corners c = corners(matches.nodes, place);
    for (size_t k = 0; k < 8; ++k)
      if (c.share[k] > 0) votes[c.node[k]].push_back({velocity, matches.weight[i] * c.share[k]});
  }
}

// The velocity that has most weight near it, and that weight.
Vote elect(const std::vector<Vote>& votes, float near) {
  Vote best{{}, 0};
  for (const Vote& candidate : votes) {
    Vote mean{{}, 0};
    for (const Vote& v : votes) {
      float off = 0;
      for (size_t a = 0; a < 3; ++a)
        off += (v.velocity[a] - candidate.velocity[a]) * (v.velocity[a] - candidate.velocity[a]);
      const float w = v.weight * std::exp(-off / (2 * near * near));
      mean.weight += w;
      for (size_t a = 0; a < 3; ++a) mean.velocity[a] += w * v.velocity[a];
    }
    if (mean.weight > best.weight) {
      for (float& v : mean.velocity) v /= mean.weight;
      best = mean;
    }
  }
  return best;
}

// Lets nodes that few things come by follow their neighbours.
void fill(Flow& flow, const std::vector<Vote>& elected) {
  float largest = 0;
  for (const Vote& v : elected) largest = std::max(largest, v.weight);
  if (largest <= 0) return;
  for (int32_t r = 0; r < rounds; ++r) {
    const std::vector<Float3> before = flow.velocity;
    for (size_t i = 0; i < before.size(); ++i) {
      const Int3 n = flow.nodes.node(i);
      float weight = 1000 * elected[i].weight / largest;
      Float3 sum;
      for (size_t a = 0; a < 3; ++a) sum[a] = weight * elected[i].velocity[a];
      for (size_t axis = 0; axis < 3; ++axis)
        for (const int32_t step : {-1, 1}) {
          Int3 other = n;
          other[axis] += step;
          if (other[axis] < 0 || other[axis] >= flow.nodes.dims[axis]) continue;
          const Float3& v = before[flow.nodes.index(other)];
          for (size_t a = 0; a < 3; ++a) sum[a] += v[a];
          weight += 1;
        }
      for (size_t a = 0; a < 3; ++a) flow.velocity[i][a] = weight > 0 ? sum[a] / weight : 0;
    }
  }
}

} // namespace

Flow join(const Matches& ahead, const Matches& back) {
  Flow flow{ahead.nodes, std::vector<Float3>(ahead.nodes.count())};
  std::vector<std::vector<Vote>> votes(flow.nodes.count());
  cast(ahead, 1, votes);
  cast(back, -1, votes);
  std::vector<Vote> elected;
  for (size_t i = 0; i < votes.size(); ++i) {
    elected.push_back(elect(votes[i], static_cast<float>(flow.nodes.spacing) / 8));
    flow.velocity[i] = elected[i].velocity;
  }
  fill(flow, elected);
  return flow;
}

} // namespace bccsplat::motion
