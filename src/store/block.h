// SPDX-License-Identifier: Apache-2.0
// What can be written in blocks of space: all that a block makes of its own samples and a halo around them.
#pragma once

#include "points/series_block.h"
#include "store/settings.h"

namespace bccsplat {

// Returns the box that was asked for with the ends that the series has; of_frames where it is all of space.
// Throws invalid_argument for one that is empty in space or reaches beyond the volume.
[[nodiscard]] SeriesBlock block_in(const std::array<uint32_t, 4>& dims, const SeriesBlock& asked);

// Throws unsupported, or invalid_argument, where samples of other blocks would decide what is written of one.
void check_block(const WriterSettings& settings);
// The same of a lattice that is settled: it has nothing outside the samples, or that is predicted with fixed
// boldness.
void check_block_lattice(const WriterSettings& settings, const Lattice4& lattice);

} // namespace bccsplat
