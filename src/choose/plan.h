// SPDX-License-Identifier: Apache-2.0
// What is known about a series and has been chosen for it.
#pragma once

#include <optional>
#include <vector>

#include "choose/lattice_choice.h"
#include "choose/level_choice.h"
#include "choose/search.h"
#include "choose/series_writer.h"
#include "choose/spectrum.h"
#include "series/frame_reader.h"
#include "series/scan.h"

namespace bccsplat::series {

struct ImportPlan {
  const SeriesDescription& series;
  const WriterSettings& settings;
  std::vector<ChannelScan> scans{}; // empty: not scanned
  std::optional<Spectra> spectra{};
  std::optional<LatticeChoice> choice{}; // of the lattice and the steps that `settings` hold
  std::optional<CodingSearch> search{};  // the same where a bound was asked for
  LevelChoice levels{};                  // of which `settings` hold the number
  std::optional<double> motion{};        // voxels a frame, of a sample
  std::optional<ErrorBound> wavelets{};  // the error that a store of wavelets promises
  bool still = false; // one frame, of whose lattice nothing was said: BCC, without a choice
};

} // namespace bccsplat::series
