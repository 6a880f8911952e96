// SPDX-License-Identifier: Apache-2.0
#include "tool/view/plane_sides.h"

#include <algorithm>
#include <cmath>

#include "tool/annotate/world_names.h"

namespace bcc4 {
namespace {

// Returns which axis of the samples is nearest to x, y and z of the world, each to one.
std::array<uint32_t, 3> nearest_axes(const bccsplat_volume_info& v) {
  std::array<uint32_t, 3> order{0, 1, 2}, best = order;
  double most = -1;
  do {
    double along = 0;
    for (size_t r = 0; r < 3; ++r) {
      const double* const m = v.affine + order[r];
      along += std::fabs(m[4 * r]) / std::hypot(m[0], m[4], m[8]);
    }
    if (along > most) most = along, best = order;
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

// A direction of the world: along one of its axes, or against it.
struct Direction {
  size_t axis;
  bool back;
};

} // namespace

std::array<PlaneSides, 3> plane_sides(const Volume& volume) {
  const bccsplat_volume_info v = volume_info(volume);
  const std::array<uint32_t, 3> axes = nearest_axes(v);
  const WorldNames plain{{{"", "x"}, {"", "y"}, {"", "z"}}};
  const WorldNames names = world_names(volume).value_or(plain);
  const auto named = [&](const Direction& d, const char* side) {
    return names[d.axis][d.back ? 0 : 1] == side;
  };
  Direction left{0, false}, front{1, false}, behind{1, false};
  if (named({0, true}, "L")) left.back = true;
  if (named({1, true}, "A")) front.back = true;
  if (named({1, true}, "P")) behind.back = true;
  const Direction head{2, false};
  const auto along = [&](const Direction& d) {
    PlaneAxis a{axes[d.axis], false, names[d.axis][d.back ? 1 : 0], names[d.axis][d.back ? 0 : 1]};
    a.falls = (v.affine[4 * d.axis + a.axis] < 0) != d.back;
    return a;
  };
  return {PlaneSides{along(left), along(head), axes[1]}, PlaneSides{along(behind), along(head), axes[0]},
          PlaneSides{along(left), along(front), axes[2]}};
}

} // namespace bcc4
