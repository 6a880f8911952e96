// SPDX-License-Identifier: Apache-2.0
// What is known about a series and has been chosen for it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "choose/lattice_choice.h"
#include "choose/level_choice.h"
#include "choose/search.h"
#include "choose/series_writer.h"
#include "choose/spectrum.h"
#include "choose/turn.h"
#include "series/frame_reader.h"
#include "series/scan.h"

namespace bccsplat::series {

// Extrapolated from a stretch of frames that went through the real writer, into nothing.
struct ImportEstimate {
  uint64_t sites = 0; // lattice sites, all channels; exact
  uint64_t sampled_frames = 0;
  double bytes_file = 0;
  double bytes_memory = 0; // data of the library and frames of the reader
  double seconds = 0;
  std::vector<bccsplat_error_report> errors; // by channel, of the sampled frames
};

struct ImportPlan {
  const SeriesDescription& series;
  const WriterSettings& settings;
  std::vector<ChannelScan> scans; // empty: not scanned
  std::optional<ImportEstimate> estimate;
  std::optional<Spectra> spectra;
  std::optional<LatticeChoice> choice;      // of the lattice and the steps that `settings` hold
  std::optional<CodingSearch> search;       // the same where a bound was asked for
  std::optional<Turn> turn;                 // of a dry run
  std::array<std::optional<Turn>, 2> round; // the same of x and y
  LevelChoice levels;                       // of which `settings` hold the number
  std::optional<double> motion{};           // voxels a frame, of a sample
  std::optional<ErrorBound> wavelets{};     // the error that a store of wavelets promises
  bool still = false; // one frame, of whose lattice nothing was said: BCC, without a choice
};

} // namespace bccsplat::series
