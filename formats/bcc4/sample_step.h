// SPDX-License-Identifier: Apache-2.0
// The steps that samples of a channel come in, for those who may round what they make of them.
#pragma once

#include "formats/bcc4/info.h"

namespace bccsplat {

// What readers round coefficients to that they make of linear samples, in steps between codes. Writers
// leave room for it where they bound errors.
inline constexpr double linear_rounding = 1.0 / 64;

// Returns 0 where nothing may be rounded: floats have no step, and the corrections of a channel whose error
// is bounded fit only the values that they were made of. Linear samples have one so small that
// linear_rounding is a quarter of it (points/rounded_brick.h).
[[nodiscard]] inline double sample_step(const ChannelInfo& channel) {
  constexpr double quarters = 4;
  if (channel.linear) return quarters * linear_rounding * channel.scale;
  const bool whole = channel.type == ValueType::u8 || channel.type == ValueType::u16;
  const ResidualInfo& corrections = channel.residuals;
  return whole && !(corrections.bound > 0) && !corrections.any() ? channel.scale : 0;
}

} // namespace bccsplat
