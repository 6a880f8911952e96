// SPDX-License-Identifier: Apache-2.0
// The order in which a batch of 4D points is evaluated: points of one window, the stretch between two layers,
// share the coefficient layers they need; within a window points of one brick share cache lines.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/context.h"

namespace bccsplat {

struct PointOrder {
  struct Group {
    int32_t window;
    uint64_t begin, end; // places
  };
  // Points that stay next to each other.
  struct Run {
    uint64_t place, point; // of the first; the run ends where the next one begins
  };
  std::vector<Group> groups;   // windows rise
  std::vector<uint64_t> order; // point of each place; empty: see runs
  std::vector<Run> runs;       // places rise; empty: the points as they are

  // The points of places begin, begin + 1 .. True where these follow each other.
  bool points_at(uint64_t begin, std::span<uint64_t> points) const;
};

// The place of a point in the order: its window, and a cell of space below `cells`.
struct PointPlace {
  int32_t window;
  uint32_t cell;
};

// `place` fills in points begin .. begin + span.size(); it is called from many threads, and for a point
// perhaps twice. Points that jump from cell to cell are gathered by cell as well, in their order otherwise.
[[nodiscard]] PointOrder order_points(uint64_t points, uint32_t cells,
                                      const std::function<void(uint64_t begin, std::span<PointPlace>)>& place,
                                      const Context& context);

} // namespace bccsplat
