// SPDX-License-Identifier: Apache-2.0
// Nodes in a frame, at which something is known, and straight between them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace bccsplat::motion {

using Float3 = std::array<float, 3>;

struct Nodes {
  Int3 dims{1, 1, 1};
  int32_t spacing = 16; // samples of the frame

  [[nodiscard]] size_t count() const { return static_cast<size_t>(dims[0]) * dims[1] * dims[2]; }
  [[nodiscard]] size_t index(const Int3& n) const {
    return (static_cast<size_t>(n[2]) * dims[1] + n[1]) * dims[0] + n[0];
  }
  [[nodiscard]] Int3 node(size_t i) const {
    const auto n = static_cast<int32_t>(i);
    return {n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]};
  }
};

// The first node lies on the first sample, the last one on the last sample or beyond.
[[nodiscard]] inline Nodes nodes_over(const Int3& samples, int32_t spacing) {
  Nodes nodes{.spacing = spacing};
  for (size_t a = 0; a < 3; ++a) nodes.dims[a] = (samples[a] - 1 + spacing - 1) / spacing + 1;
  return nodes;
}

// Where a place lies between two nodes of an axis.
struct Between {
  int32_t first = 0, second = 0;
  float share = 0; // of the second
};
[[nodiscard]] inline Between between(const Nodes& nodes, size_t axis, float place) {
  const auto last = static_cast<float>(nodes.dims[axis] - 1);
  const float at = std::clamp(place / static_cast<float>(nodes.spacing), 0.f, last);
  const int32_t first = std::min(static_cast<int32_t>(at), std::max(nodes.dims[axis] - 2, 0));
  return {first, std::min(first + 1, nodes.dims[axis] - 1), at - static_cast<float>(first)};
}

// The eight nodes around a place, and their shares.
struct Corners {
  std::array<size_t, 8> node;
  std::array<float, 8> share;
};
[[nodiscard]] inline Corners corners(const Nodes& nodes, const Float3& place) {
  std::array<Between, 3> b;
  for (size_t a = 0; a < 3; ++a) b[a] = between(nodes, a, place[a]);
  Corners c;
  for (size_t k = 0; k < 8; ++k) {
    const bool x = k & 1, y = k & 2, z = k & 4;
    c.node[k] = nodes.index(
        {x ? b[0].second : b[0].first, y ? b[1].second : b[1].first, z ? b[2].second : b[2].first});
    c.share[k] = (x ? b[0].share : 1 - b[0].share) * (y ? b[1].share : 1 - b[1].share) *
                 (z ? b[2].share : 1 - b[2].share);
  }
  return c;
}

// Where things go: at each node how many samples of the frame they move from one frame to the next one that
// is stored. A velocity belongs to where a thing is halfway.
struct Flow {
  Nodes nodes;
  std::vector<Float3> velocity;

  [[nodiscard]] Float3 at(const Float3& place) const {
    const Corners c = corners(nodes, place);
    Float3 v{};
    for (size_t k = 0; k < 8; ++k)
      for (size_t a = 0; a < 3; ++a) v[a] += c.share[k] * velocity[c.node[k]][a];
    return v;
  }
};

} // namespace bccsplat::motion
