// SPDX-License-Identifier: Apache-2.0
// How far levels are from the source, as far as a file tells.
#pragma once

#include <optional>

#include "formats/bcc4/info.h"

namespace bccsplat {

// Returns the error of a kind that was measured of a level; null where it was not measured, or where the
// source has no range.
[[nodiscard]] const MeasuredError* find_error(const VolumeInfo& info, uint32_t channel, uint32_t level,
                                              MeasuredError::Kind kind = MeasuredError::stored);

// What a coarser level adds to the error of level 0, which no picture is free of: rounding of the source and
// of what is stored, and what the lattice cannot hold. A level is a low-pass of level 0, so that the squares
// of what either loses add up.
struct LevelError {
  double rmse = 0;    // added, of the range of the source, over the part of the sites that is kept
  double largest = 0; // with that of level 0, of the range of the source
};

// None where the level was not measured.
[[nodiscard]] std::optional<LevelError> level_error(const VolumeInfo& info, uint32_t channel, uint32_t level);

} // namespace bccsplat
