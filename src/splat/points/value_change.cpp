// SPDX-License-Identifier: Apache-2.0
#include "splat/points/value_change.h"

#include <algorithm>
#include <vector>

#include "shade/surface.h"

namespace bccsplat {
namespace {

// Points of the slice that are asked how fast the field changes, and the percentile taken of them: a tenth of
// a millisecond per picture (tests/bench/notes/pre-integration.md).
constexpr size_t asked_points = 512, change_percentile = 95;

} // namespace

double change_per_unit(const Slice& slice, const SplatPoints& points) {
  std::vector<Vec3> places;
  const size_t every = std::max<size_t>(1, points.count / asked_points);
  size_t next = every / 2;
  for (const SplatBrick& b : points.bricks)
    for (; next < b.first + size_t{b.count}; next += every)
      if (const Vec3 p = points.at(b, static_cast<uint32_t>(next)); slice.inside(p)) places.push_back(p);
  if (places.empty()) return 0;
  std::vector<float> values(places.size());
  std::vector<Vec3> gradients(places.size());
  field_at(SurfaceField(slice), places, values, gradients);
  std::vector<double> lengths;
  for (const Vec3& g : gradients) lengths.push_back(length(g));
  const auto at = lengths.begin() + lengths.size() * change_percentile / 100;
  std::nth_element(lengths.begin(), at, lengths.end());
  return *at;
}

} // namespace bccsplat
