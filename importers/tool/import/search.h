// The coarsest coding that keeps the error a user accepts, found on a part of the series that goes through
// the real writer.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "readers/scan.h"
#include "tool/import/sample.h"
#include "tool/import/series_writer.h"
#include "tool/json.h"

namespace bcc4 {

// Where it takes corrections to reach a PSNR, no sample is left off by more than so many times the root of
// the mean square error that it allows.
inline constexpr double kCorrectedPeak = 1.5;

// What was asked for: one of the two.
struct ErrorBound {
  double abs = 0;  // value; 0: none
  double psnr = 0; // dB over the series, peak: its range; 0: none
  [[nodiscard]] bool any() const { return abs > 0 || psnr > 0; }
};

// A coding and what it gave on the sample.
struct CodingTrial {
  double scale = 1, time_scale = 1;
  int32_t lattice = BCCSPLAT_LATTICE_DEFAULT;
  double step = 0;      // value between codes; 0: the type holds the source as it is
  double abs_error = 0; // of the corrections; 0: none
  uint64_t bytes = 0;   // of the sample's file, corrections included
  double max_abs = 0, psnr = 0;
  uint64_t corrected = 0; // samples
  bool holds = false;
};

struct CodingSearch {
  std::vector<CodingTrial> tried;
  size_t best = 0;
  uint64_t sampled_frames = 0;
  [[nodiscard]] const CodingTrial& chosen() const { return tried[best]; }
};

// Options the user gave (scale, time scale, lattice, type of values) are kept; `scans` of the whole series.
[[nodiscard]] CodingSearch search_coding(const Device& device, const SeriesDescription& series,
                                         const std::vector<SampleStretch>& sample,
                                         const WriterSettings& settings, const ErrorBound& bound,
                                         const std::vector<ChannelScan>& scans);

// The coarsest time scale up to `most` at which the sample keeps a PSNR that is good, or next to that of
// scale 1.
[[nodiscard]] double prove_time_scale(const Device& device, const SeriesDescription& series,
                                      const std::vector<SampleStretch>& sample,
                                      const WriterSettings& settings, double most,
                                      const std::vector<ChannelScan>& scans);

// The settings that make the writer use a coding.
[[nodiscard]] WriterSettings apply_coding(WriterSettings settings, const CodingTrial& trial,
                                          const ErrorBound& bound);

// Largest range of a channel; the one that a PSNR refers to.
[[nodiscard]] double peak_of(const std::vector<ChannelScan>& scans);

[[nodiscard]] std::string coding_text(const CodingTrial& trial);
[[nodiscard]] Json search_json(const CodingSearch& search);

} // namespace bcc4
