// SPDX-License-Identifier: Apache-2.0
#include "slice/part.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "field/footprint/patch.h"

namespace bccsplat {
namespace {

constexpr char axis_name[] = "xyz";

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

int sites_in_reach(const Lattice4& lattice, const Kernel& kernel) {
  const double other_coset = lattice.space.bcc ? 0.5 : 0; // whose sites stand so far from those of coset 0
  return static_cast<int>(std::ceil(kernel.space.radius / coset_pitch(lattice.space) + other_coset));
}

BrickBox bricks_around(const IndexBox& box, const Lattice4& lattice, int sites) {
  constexpr double rounding = 1e-6; // of sites
  const int per_site = lattice.space.bcc ? 2 : 1;
  BrickBox bricks;
  for (size_t a = 0; a < 3; ++a) {
    const auto site = [&](double position) {
      return (position / lattice.space_step[a] + lattice.before[a]) / per_site;
    };
    const int first = static_cast<int>(std::floor(site(box.begin[a]) - rounding)) - sites,
              last = static_cast<int>(std::floor(site(box.end[a]) + rounding)) + sites;
    bricks.begin[a] = std::max(0, first) / brick_edge, bricks.end[a] = last / brick_edge + 1;
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
