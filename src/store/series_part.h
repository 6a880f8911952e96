// SPDX-License-Identifier: Apache-2.0
// A part of a series that several processes write, or that continues a file: what it must be given, and what
// it makes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "fit/fit.h"
#include "formats/bcc4/info.h"

namespace bccsplat {

// What is measured of a series.
struct MeasuredFrames {
  std::string kernel;                 // with this one
  std::span<const uint32_t> frames{}; // rising, of the whole series
};

// Frames and layers by their numbers in the series.
struct SeriesPart {
  int32_t first_slab = 0, end_slab = 0; // stored
  // The bricks of level 0 of a block that the field at its samples is a sum of, where it is measured.
  BrickBox measured;
  FitPart fit; // of what is stored or measured
};
// A part of a series: slabs whose first layer stands at one of its frames or between them and the end of
// these, and of a block of space the bricks that bricks_of tells. options: of the series, dims[3] known.
[[nodiscard]] SeriesPart part_of_series(const Lattice4& lattice, const FitOptions& options,
                                        const MeasuredFrames& measured, const SeriesBlock& block);
// Returns the bricks of a block that are made, where nothing is measured: those that are stored.
[[nodiscard]] LayerBricks layer_bricks_of(const SeriesBlock& block, const Lattice4& lattice);

// Slabs of a series of `frames` frames that stay as they are when more follow; lattice: of either.
[[nodiscard]] int32_t lasting_slabs(const Lattice4& lattice, const FitOptions& options, uint32_t frames);
// Returns what is left to do when a series of which `done` frames are in a file goes on: the slabs behind
// lasting_slabs, from as many frames as they depend on. lattice, options: of the longer series.
[[nodiscard]] SeriesPart rest_of_series(const Lattice4& lattice, const FitOptions& options, uint32_t done);
// Lets a part begin with `frames` more frames than it needs, those before its first one.
void begin_earlier(uint64_t frames, FitPart& part);

// Puts into the file what a writer that continues a whole series will ask for. lasting: of its slabs.
void describe_tail(int32_t lasting, std::span<const FitChannelReport> channels, VolumeInfo& info);

} // namespace bccsplat
