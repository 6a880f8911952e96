// SPDX-License-Identifier: Apache-2.0
// A moment between frames, summed up along the ways of things:
// f(x, t) = sum_l w_l(t) F_l( x + (t_l - t) v(x) ).
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "tests/bench/motion/flow/box.h"
#include "tests/bench/motion/flow/nodes.h"
#include "tests/bench/motion/flow/shares.h"
#include "tests/bench/motion/flow/spline.h"

namespace bccsplat::motion {

// The field at a place of a moment, by the frames that shares name.
class Ways {
 public:
  // halfway: how far the moment is before the middle of its interval, in its length.
  Ways(const Flow& flow, std::span<const Spline* const> frames, std::vector<Share> shares, float halfway)
      : flow_(flow), frames_(frames), shares_(std::move(shares)), halfway_(halfway) {}

  // `near`: the flow's velocity at the place.
  [[nodiscard]] float value(const Float3& place, const Float3& near) const;

 private:
  const Flow& flow_;
  std::span<const Spline* const> frames_;
  std::vector<Share> shares_;
  float halfway_;
};

// Where the mask (0 to 1 at nodes, straight between them; empty: 1) is 0 the moment is `still` as it is.
[[nodiscard]] Box sum_along(const Ways& ways, const Flow& flow, std::span<const float> mask,
                            const Box& still);

} // namespace bccsplat::motion
