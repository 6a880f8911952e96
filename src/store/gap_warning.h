// SPDX-License-Identifier: Apache-2.0
// A warning of gaps in time that nobody has measured. Frames are one unit of time apart whatever their times
// are: what happens in a gap happens within one frame, and the field next to it is off by as much as the
// kernel smooths such a jump.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace bccsplat {

// Returns what to say of the largest gap of more than three usual steps of which not both frames are among
// those measured, in rising order; empty: there is none.
[[nodiscard]] std::string gap_warning(std::span<const double> times, std::span<const uint32_t> measured);

} // namespace bccsplat
