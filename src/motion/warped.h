// SPDX-License-Identifier: Apache-2.0
// The field between frames, summed up along the ways of things:
// f(x, t) = sum_l w_l(t) F_l( x + (t_l - t) v(x) ).
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "motion/box.h"
#include "motion/nodes.h"
#include "motion/shares.h"
#include "motion/spline.h"

namespace bccsplat::motion {

// The velocity of what is at a place of a moment, which belongs to where it is halfway. halfway: how far the
// moment is before the middle of its interval, in its length; near: the flow's velocity at the place.
[[nodiscard]] inline Float3 velocity_at(const Flow& flow, const Float3& place, const Float3& near,
                                        float halfway) {
  Float3 middle;
  for (size_t a = 0; a < 3; ++a) middle[a] = place[a] + halfway * near[a];
  return halfway == 0 ? near : flow.at(middle);
}

// The field at a place of a moment, by the frames that shares name.
class Ways {
 public:
  Ways(const Flow& flow, std::span<const Spline* const> frames, std::vector<Share> shares, float halfway)
      : flow_(flow), frames_(frames), shares_(std::move(shares)), halfway_(halfway) {}

  [[nodiscard]] float value(const Float3& place, const Float3& near) const {
    const Float3 v = velocity_at(flow_, place, near, halfway_);
    float sum = 0;
    for (const Share& s : shares_) {
      Float3 there;
      for (size_t a = 0; a < 3; ++a) there[a] = place[a] + s.ahead * v[a];
      sum += s.weight * frames_[s.frame]->value(there);
    }
    return sum;
  }

 private:
  const Flow& flow_;
  std::span<const Spline* const> frames_;
  std::vector<Share> shares_;
  float halfway_;
};

} // namespace bccsplat::motion
