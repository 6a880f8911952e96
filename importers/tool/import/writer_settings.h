// SPDX-License-Identifier: Apache-2.0
// The options of a writer as an import keeps them, and the library's writer of them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/handles.h"

namespace bcc4 {

// Its own pointers are not in use: what they would point to is here, or told by the series.
struct WriterSettings : bccsplat_writer_options {
  std::vector<bccsplat_channel_options> values;    // by channel, without name and unit
  std::vector<double> mean_errors, largest_errors; // by channel: wavelet_errors, abs_errors; or none
  std::string kernel;
  WriterSettings() : bccsplat_writer_options(sized<bccsplat_writer_options>()) {}
};

// The number of a type in the C ABI.
[[nodiscard]] int32_t library_type(Type type);
// The type that a channel is stored in.
[[nodiscard]] int32_t stored_type(const bccsplat_channel_options& channel);
// The boxes of a frame as the library takes them, without a copy of the values.
[[nodiscard]] std::vector<bccsplat_box> library_boxes(const Frame& frame);

// The library's options of settings for a series; both must outlive it.
struct SeriesOptions {
  SeriesOptions(const SeriesDescription& series, const WriterSettings& settings);
  SeriesOptions(const SeriesOptions&) = delete;
  SeriesOptions& operator=(const SeriesOptions&) = delete;

  bccsplat_writer_options options;

 private:
  std::vector<bccsplat_channel_options> channels_;
  std::array<bccsplat_axis, 3> axes_{};
  std::array<std::string, 3> axis_units_;
  std::string spatial_unit_, time_unit_;
};

// `frames` replaces the number of frames of the series. With `path` empty the bytes go nowhere: for
// estimates. part: null for the whole series.
[[nodiscard]] Writer create_writer(const Device& device, const std::string& path,
                                   const SeriesDescription& series, const WriterSettings& settings,
                                   uint64_t frames, const bccsplat_series_part* part = nullptr);

} // namespace bcc4
