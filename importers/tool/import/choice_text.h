// SPDX-License-Identifier: Apache-2.0
// What was chosen for a series, and what it was chosen by, in lines of a report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "choose/lattice_choice.h"
#include "choose/level_choice.h"
#include "choose/spectrum.h"
#include "readers/frame_reader.h"

namespace bcc4 {

[[nodiscard]] std::vector<std::string> choice_lines(const LatticeChoice& choice,
                                                    const SeriesDescription& series);
[[nodiscard]] std::vector<std::string> spectrum_lines(const Spectrum& spectrum);
// Returns what is said about levels; empty: nothing.
[[nodiscard]] std::string levels_text(const LevelChoice& choice, uint32_t levels);
// What to say where moments between frames will not be what was between them; else "".
[[nodiscard]] std::string motion_text(const std::optional<double>& voxels, const Spectrum& spectrum);

} // namespace bcc4
