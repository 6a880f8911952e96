// Values of kept sites to their places in a brick.
#pragma once

#include <span>

#include "points/brick.h"

namespace bccsplat {

// `values`: those of the kept sites; as many floats as a row has can be read before and behind them. All of
// `brick` is written, 0 where no site is kept.
void spread_values(const BrickMask& kept, const float* values, std::span<float, brick_sites> brick);

} // namespace bccsplat
