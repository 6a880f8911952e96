// SPDX-License-Identifier: Apache-2.0
// How far things move from one frame to the next.
#pragma once

#include <optional>

#include "choose/sample.h"

namespace bccsplat::series {

// Voxels, in the middle of the boxes that change most. None where these are not found again in the next
// frame, as of noise, or move farther than a third of a box.
[[nodiscard]] std::optional<double> voxels_a_frame(const SeriesSample& sample);

} // namespace bccsplat::series
