// SPDX-License-Identifier: Apache-2.0
// The options of a writer as an import keeps them, and the library's writer of them.
#pragma once

#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/handles.h"

namespace bcc4 {

using bccsplat::series::library_type;
using bccsplat::series::SeriesOptions;

// Its own pointers are not in use: what they would point to is here, or told by the series.
struct WriterSettings : bccsplat_writer_options {
  std::vector<bccsplat_channel_options> values;    // by channel, without name and unit
  std::vector<double> mean_errors, largest_errors; // by channel: wavelet_errors, abs_errors; or none
  std::string kernel;
  WriterSettings() : bccsplat_writer_options(sized<bccsplat_writer_options>()) {}
};

// The type that a channel is stored in.
[[nodiscard]] int32_t stored_type(const bccsplat_channel_options& channel);
// The boxes of a frame as the library takes them, without a copy of the values.
[[nodiscard]] std::vector<bccsplat_box> library_boxes(const Frame& frame);

// The library's options of settings for a series, which must outlive them.
[[nodiscard]] SeriesOptions series_options(const SeriesDescription& series, const WriterSettings& settings);

// `frames` replaces the number of frames of the series. With `path` empty the bytes go nowhere: for
// estimates. part: null for the whole series.
[[nodiscard]] Writer create_writer(const Device& device, const std::string& path,
                                   const SeriesDescription& series, const WriterSettings& settings,
                                   uint64_t frames, const bccsplat_series_part* part = nullptr);

} // namespace bcc4
