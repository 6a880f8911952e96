// SPDX-License-Identifier: Apache-2.0
// Whether a flow may be trusted: a frame is left out, a flow found between its neighbours, and where that
// predicts the frame better than the frames alone do, by a margin, moments follow the motion.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "motion/flow.h"
#include "motion/shares.h"

namespace bccsplat::motion {

// Around each node, sums of squares by which a frame is predicted wrongly.
struct Trial {
  std::vector<float> still, moved; // without the flow, and with it
};

// frames: all that are at hand, by number; those a share does not name may be null. flow: found between the
// two around `left_out`.
[[nodiscard]] Trial try_frame(const Flow& flow, std::span<const Spline* const> frames,
                              const std::vector<Share>& shares, float halfway, const Box& left_out);

// The same of an interval: how much its frames differ where they stand, and along the flow.
[[nodiscard]] Trial try_interval(const Flow& flow, const Spline& first, const Spline& second);

// Shares of the motion at nodes. Of trials of the frames at the ends of an interval: the share of them that
// say so; theta: how much less the error has to be with the flow than without it.
inline constexpr float usual_theta = .8f;
[[nodiscard]] std::vector<float> gate(std::span<const Trial* const> trials, float theta = usual_theta);
// Where no frame can be left out: the less the frames differ along the flow, the nearer to 1.
[[nodiscard]] std::vector<float> soft_mask(const Trial& interval);

} // namespace bccsplat::motion
