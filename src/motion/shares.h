// SPDX-License-Identifier: Apache-2.0
// Which frames a moment is made of, and how much each counts.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bccsplat::motion {

struct Share {
  size_t frame = 0;
  float weight = 0;
  float ahead = 0; // of the moment, in the length of the interval that it lies in
};

// The interval of `times` (rising, two at least) that a time lies in: the number of the frame before it.
[[nodiscard]] size_t interval_of(std::span<const double> times, double time);
// How far a time is before the middle of its interval, in the length of that.
[[nodiscard]] float before_middle(std::span<const double> times, double time);

// The cubic through the two frames on either side of a time; a frame that is much further away than these are
// from each other, or is not there, is left out, and the cubic becomes a parabola or a straight line.
[[nodiscard]] std::vector<Share> cubic_shares(std::span<const double> times, double time);
// The same of the two frames around it.
[[nodiscard]] std::vector<Share> linear_shares(std::span<const double> times, double time);

} // namespace bccsplat::motion
