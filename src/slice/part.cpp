// SPDX-License-Identifier: Apache-2.0
#include "slice/part.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

constexpr char axis_name[] = "xyz";
// Sites of a coset: a kernel takes at most four in a row, and so does the low-pass of coarser slices.
constexpr int field_sites = 8;

} // namespace

IndexBox clip_to_samples(const IndexBox& box, const Lattice4& lattice) {
  IndexBox inside;
  for (size_t a = 0; a < 3; ++a) {
    const double last = lattice.domain_end(a);
    if (box.begin[a] > last || box.end[a] < 0)
      fail(Code::out_of_domain, "slice: the box misses the samples, 0 to ", last, " along ", axis_name[a]);
    inside.begin[a] = std::max(box.begin[a], 0.0), inside.end[a] = std::min(box.end[a], last);
  }
  return inside;
}

BrickBox bricks_around(const IndexBox& box, const Lattice4& lattice, BeyondBox beyond) {
  const int margin = field_sites + (beyond == BeyondBox::prefilter ? brick_edge : 0);
  const int per_site = lattice.space.bcc ? 2 : 1;
  BrickBox bricks;
  for (size_t a = 0; a < 3; ++a) {
    const auto site = [&](double position) {
      const double plane = position / lattice.space_step[a] + lattice.before[a];
      return static_cast<int>(std::floor(plane / per_site));
    };
    bricks.begin[a] = std::max(0, site(box.begin[a]) - margin) / brick_edge;
    bricks.end[a] = (site(box.end[a]) + margin) / brick_edge + 1;
  }
  return go_round(bricks, lattice.space);
}

void cut_to_box(Slice& slice, const IndexBox& box) {
  const Affine3 to_lattice = slice.lattice_to_slice.inverse();
  const Vec3 begin = to_lattice.point(box.begin), end = to_lattice.point(box.end);
  for (size_t a = 0; a < 3; ++a) {
    slice.domain_begin[a] = std::max(slice.domain_begin[a], begin[a]);
    slice.domain_end[a] = std::min(slice.domain_end[a], end[a]);
  }
}

} // namespace bccsplat
