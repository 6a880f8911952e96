// SPDX-License-Identifier: Apache-2.0
// Codings tried on a sample of a series: through the real writer and back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "choose/lattice_shape.h"
#include "choose/sample.h"
#include "choose/series_writer.h"
#include "series/scan.h"

namespace bccsplat::series {

// A way to store a series.
struct Coding {
  LatticeShape shape;
  std::vector<StepCoding> steps; // by channel; none: the type holds the source as it is
  double abs_error = 0;          // of the corrections; 0: none
  bool operator==(const Coding&) const = default;
};

// What a coding gave on the sample.
struct CodingTrial {
  Coding coding;
  uint64_t bytes = 0;               // of the sample's files, corrections included
  std::vector<double> mean_squares; // errors by channel, predicted for the series
  double max_abs = 0;
  double psnr = 0;   // dB of the channel that has the lowest, peak: its range
  bool holds = true; // no bound was out of reach
};

// The settings that make the writer use a coding.
[[nodiscard]] WriterSettings apply_coding(WriterSettings settings, const Coding& coding);

// Gives all frames of a stretch, which `part` describes, to the writer and finishes it; false when it cannot
// keep a bound. report may be NULL.
[[nodiscard]] bool write_stretch(const Writer& writer, const SeriesDescription& part,
                                 const SampleStretch& stretch, Watch& watch, bccsplat_writer_report* report);

class Trier {
 public:
  // All is borrowed. scans: for the writer; ranges: the peaks of PSNRs.
  Trier(const Device& device, const SeriesDescription& series, const SeriesSample& sample,
        const WriterSettings& settings, const std::vector<ChannelScan>& scans,
        const std::vector<ChannelScan>& ranges, Watch& watch)
      : device_(device), series_(series), sample_(sample), settings_(settings), scans_(scans),
        ranges_(ranges), watch_(watch) {}

  // Runs the sample through the writer, unless it was tried before; its place in tried().
  size_t try_coding(const Coding& coding);
  // The same of a coding without steps, unless it turns out on the way that its PSNR stays below `least`.
  std::optional<size_t> try_above(const Coding& coding, double least);
  [[nodiscard]] const std::vector<CodingTrial>& tried() const { return tried_; }
  [[nodiscard]] Watch& watch() const { return watch_; }
  // Every second frame of the sample, the others blended of their neighbours: PSNR as of a trial.
  [[nodiscard]] double half_the_frames() const;

 private:
  [[nodiscard]] int32_t ends_of(const SampleStretch& stretch, const LatticeShape& shape) const;
  [[nodiscard]] std::optional<size_t> find(const Coding& coding) const;
  // None: its PSNR is below `least`.
  std::optional<CodingTrial> measure(const Coding& coding, double least);
  [[nodiscard]] bool measure_stretch(const SampleStretch& stretch, CodingTrial& trial,
                                     std::vector<double>& mean_squares) const;
  [[nodiscard]] double share_of_ranges(const std::vector<double>& mean_squares) const;
  void weigh_rounding(CodingTrial& trial, const CodingTrial& plain) const;
  [[nodiscard]] double psnr_of(const std::vector<double>& mean_squares) const;

  const Device& device_;
  const SeriesDescription& series_;
  const SeriesSample& sample_;
  const WriterSettings& settings_;
  const std::vector<ChannelScan>& scans_;
  const std::vector<ChannelScan>& ranges_;
  Watch& watch_;
  std::vector<CodingTrial> tried_;
  std::vector<size_t> order_; // of the stretches: those where a lattice loses most first
};

// "45.2 dB", or "exact".
[[nodiscard]] std::string decibels_text(double psnr);
// "values in steps of 3"; empty: none.
[[nodiscard]] std::string steps_text(const Coding& coding, const SeriesDescription& series);
[[nodiscard]] std::string coding_text(const CodingTrial& trial, const SeriesDescription& series);

} // namespace bccsplat::series
