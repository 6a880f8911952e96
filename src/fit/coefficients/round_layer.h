// SPDX-License-Identifier: Apache-2.0
// Rounds a layer to what a file can hold.
#pragma once

#include "base/context.h"
#include "points/brick.h"
#include "points/values.h"

namespace bccsplat {

// Rounds every site and keeps those further than `threshold` from air, with threshold 0 those that are not
// stored as air, and holes. Values are relative to air, before and after. Not for steps of coefficients
// (coefficient_steps.h).
// clamped grows by the sites that the type cannot hold.
[[nodiscard]] BrickLayer round_layer(const BrickLayer& layer, const Quantiser& quantiser, float threshold,
                                     uint64_t& clamped, const Context& context);

} // namespace bccsplat
