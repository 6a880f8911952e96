// SPDX-License-Identifier: Apache-2.0
#include "points/series_block.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// Returns the first brick along an axis whose first site stands at a sample or behind it.
int32_t brick_at(uint32_t sample, const Lattice4& lattice, size_t axis) {
  const int32_t bricks = (lattice.space.dims(0)[axis] + brick_edge - 1) / brick_edge;
  if (sample == 0) return 0; // with those outside the face
  if (sample >= lattice.dims[axis]) return bricks;
  const auto place = [&](int32_t brick) {
    return lattice.plane_position(axis, lattice.space.plane(0, brick * brick_edge));
  };
  const double edge = place(1) - place(0);
  auto brick = static_cast<int32_t>(std::clamp((sample - place(0)) / edge, 0.0, static_cast<double>(bricks)));
  while (brick > 0 && place(brick - 1) >= sample) --brick;
  while (brick < bricks && place(brick) < sample) ++brick;
  return brick;
}

} // namespace

std::vector<SeriesBlock> without(SeriesBlock box, const SeriesBlock& taken) {
  const SeriesBlock both = box.cut(taken);
  if (both.empty()) return {box};
  std::vector<SeriesBlock> left;
  for (size_t i = 4; i > 0; --i) { // frames first: what is missing is best told by them
    const size_t a = i - 1;
    SeriesBlock before = box, behind = box;
    before.end[a] = both.begin[a], behind.begin[a] = both.end[a];
    if (!before.empty()) left.push_back(before);
    if (!behind.empty()) left.push_back(behind);
    box.begin[a] = both.begin[a], box.end[a] = both.end[a];
  }
  return left;
}

BrickBox bricks_of(const SeriesBlock& block, const Lattice4& lattice) {
  if (block.all_space()) return {};
  BrickBox box;
  for (size_t a = 0; a < 3; ++a) {
    box.begin[a] = brick_at(block.begin[a], lattice, a);
    box.end[a] = brick_at(block.end[a], lattice, a);
  }
  return box;
}

BrickBox bricks_near(const SeriesBlock& block, const Lattice4& lattice, int32_t sites) {
  if (block.all_space()) return {};
  BrickBox box;
  for (size_t a = 0; a < 3; ++a) {
    const int32_t count = lattice.space.dims(0)[a];
    const auto place = [&](int32_t site) { return lattice.plane_position(a, lattice.space.plane(0, site)); };
    const double first = place(0), edge = place(1) - first;
    const double last_sample = std::min(block.end[a], lattice.dims[a]) - 1.0;
    const auto site = [&](double at) { return static_cast<int32_t>(std::clamp(at, 0.0, count - 1.0)); };
    box.begin[a] = site(std::floor((block.begin[a] - first) / edge) - sites) / brick_edge;
    box.end[a] = site(std::ceil((last_sample - first) / edge) + sites) / brick_edge + 1;
  }
  return box;
}

} // namespace bccsplat
