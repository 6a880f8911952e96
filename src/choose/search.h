// SPDX-License-Identifier: Apache-2.0
// The coarsest coding that keeps the error a user accepts, found on a part of the series that goes through
// the real writer.
#pragma once

#include <vector>

#include "choose/lattice_fit.h"
#include "choose/trial.h"

namespace bccsplat::series {

// Where it takes corrections to reach a PSNR, no sample is left off by more than so many times the root of
// the mean square error that it allows.
inline constexpr double kCorrectedPeak = 1.5;

// The error that a file may have at the source samples: one of the first two where somebody asks for it.
struct ErrorBound {
  double abs = 0;           // largest, a value; 0: none
  double psnr = 0;          // dB over the series, peak: its range; 0: none
  double share = 0;         // largest, as a share of each channel's range; 0: none
  bool outside_air = false; // does the PSNR leave air out of the mean?
  [[nodiscard]] bool any() const { return abs > 0 || psnr > 0; }
};

// Returns what was asked for, or what a store promises that nobody asked anything of.
[[nodiscard]] ErrorBound usual_bound(const ErrorBound& asked, int32_t store);

struct CodingSearch {
  std::vector<CodingTrial> tried;
  size_t best = 0;
  uint64_t sampled_frames = 0;
  [[nodiscard]] const CodingTrial& chosen() const { return tried[best]; }
};

// Options the user gave (scales, lattice, type of values) are kept; `scans` of the whole series.
[[nodiscard]] CodingSearch search_coding(Trier& trier, const Spectra& spectra,
                                         const SeriesDescription& series, const WriterSettings& settings,
                                         const ErrorBound& bound, const std::vector<ChannelScan>& scans);

// The coarsest time scale at which the sample keeps a PSNR that is good, or next to that of scale 1.
[[nodiscard]] double prove_time_scale(Trier& trier, const Spectrum& spectrum, const SeriesDescription& series,
                                      const WriterSettings& settings);

// Do the settings say distances?
[[nodiscard]] bool has_distances(const WriterSettings& settings);
// The shape that settings ask for: 1 where they do not say it.
[[nodiscard]] LatticeShape shape_of(const WriterSettings& settings, const SeriesDescription& series);

// Largest range of a channel; the one that a PSNR refers to.
[[nodiscard]] double peak_of(const std::vector<ChannelScan>& scans);

} // namespace bccsplat::series
