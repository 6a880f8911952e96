// SPDX-License-Identifier: Apache-2.0
// How far things move from one frame to the next.
#pragma once

#include <optional>
#include <string>

#include "tool/import/sample.h"
#include "tool/import/spectrum.h"

namespace bcc4 {

// Voxels, in the middle of the boxes that change most. None where these are not found again in the next
// frame, as of noise, or move farther than a third of a box.
[[nodiscard]] std::optional<double> voxels_a_frame(const SeriesSample& sample);

// What to say where moments between frames will not be what was between them; else "".
[[nodiscard]] std::string motion_text(const std::optional<double>& voxels, const Spectrum& spectrum);

} // namespace bcc4
