// SPDX-License-Identifier: Apache-2.0
// A series as the reader describes it -> the writer of the library.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "series/frame_reader.h"
#include "series/library.h"
#include "series/scan.h"

namespace bccsplat::series {

// Codes of u16 a step apart that are the values of a channel; step 0: it has those of its type.
struct StepCoding {
  double step = 0;
  std::array<double, 2> range{};
  bool operator==(const StepCoding&) const = default;
};

struct WriterSettings {
  std::optional<double> air;
  std::map<std::string, double> own_air; // of channels, where `air` is not given
  double air_threshold = 0;
  int32_t lattice = BCCSPLAT_LATTICE_DEFAULT;
  bool lowpass = false;
  int32_t ends = BCCSPLAT_ENDS_DEFAULT;
  int32_t faces = BCCSPLAT_FACES_DEFAULT;
  int32_t periodic = 0; // axes: BCCSPLAT_PERIODIC_...
  int32_t store = BCCSPLAT_STORE_DEFAULT;
  uint32_t levels = 0;            // coarser ones
  bool fixed_predictions = false; // beyond faces and ends, which blocks need
  int32_t nonfinite = BCCSPLAT_NONFINITE_DEFAULT;
  int32_t quantize = BCCSPLAT_TYPE_DEFAULT;
  double scale = 0; // 0: the library's default
  double time_scale = 0;
  std::array<double, 4> scales{};     // of single axes, before those; 0: by them
  std::vector<StepCoding> steps;      // by channel; none: by `quantize`
  std::vector<bool> labels;           // by channel; none: not known
  std::vector<double> wavelet_errors; // by channel, of a store of wavelets
  double abs_error = 0, psnr = 0;     // bounds; 0: none
  std::vector<double> abs_errors;     // by channel, in the place of abs_error
  int32_t measure = BCCSPLAT_MEASURE_DEFAULT;
  std::string kernel;
  bool overwrite = false;
  int32_t partial = BCCSPLAT_PARTIAL_DEFAULT;    // of files
  uint32_t live = 0;                             // of files: shown after so many slabs
  bccsplat_cancel_token* cancel_token = nullptr; // borrowed; may be null
};

// Codes a step apart that are the integers of a scaled source, or lie between them where air does.
struct ScaledCoding {
  int32_t type = BCCSPLAT_TYPE_DEFAULT;
  double step = 0;
  std::array<double, 2> range{};
};
// None: the source is not scaled, or the settings ask for other values, or air is too far from its range.
[[nodiscard]] std::optional<ScaledCoding> scaled_coding(const Channel& channel,
                                                        const WriterSettings& settings);
// Returns the step from one value of a channel to the next; 0: floats.
[[nodiscard]] double source_step(const Channel& channel);
// Does the kernel of that name have a form for the Cartesian lattice?
[[nodiscard]] bool has_cartesian(const std::string& kernel);
// The type a channel is stored in.
[[nodiscard]] int32_t stored_type(const Channel& channel, const WriterSettings& settings);
// Codes `step` apart for a channel of which `known` is known, with room for values that come later; those of
// its type where they are too many.
[[nodiscard]] StepCoding step_coding(double step, const ChannelScan& known, double air, int32_t nonfinite);
// Returns by channel steps of at most `widest`: of integers whole numbers of their own, if two or more fit;
// 0: as the source. None where no channel has any.
[[nodiscard]] std::vector<StepCoding> whole_steps(const std::vector<double>& widest,
                                                  const SeriesDescription& series,
                                                  const WriterSettings& settings,
                                                  const std::vector<ChannelScan>& known);
// Are there codes enough for whatever comes, so that its range need not be known?
[[nodiscard]] bool has_wide_codes(double step, const ChannelScan& known);
// The value from code to code of a channel; 0: that of its type.
[[nodiscard]] double step_of(const WriterSettings& settings, size_t channel);
// Integers of another width or floats stored as u8 or u16 need the range of the whole series, and so do
// infinities that become its ends.
[[nodiscard]] bool needs_range(const Channel& channel, const WriterSettings& settings);
// Returns the air of a channel; unless given, that of scaled integers is a value that the source has.
[[nodiscard]] double air_of(const Channel& channel, const WriterSettings& settings);

// The options of a writer as they were chosen.
struct ChosenOptions : SeriesOptions {
  ChosenOptions(const SeriesDescription& series, const WriterSettings& settings,
                const std::vector<ChannelScan>& scans);
};

// A writer of a trial. `frames` replaces the number of frames of the description. `scans` may be empty unless
// a range is needed. The bytes go to `stream`, or nowhere.
[[nodiscard]] Writer create_writer(const Device& device, const SeriesDescription& series,
                                   const WriterSettings& settings, const std::vector<ChannelScan>& scans,
                                   uint64_t frames, const bccsplat_write_stream* stream = nullptr);

} // namespace bccsplat::series
