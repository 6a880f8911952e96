// SPDX-License-Identifier: Apache-2.0
// What a user may tell the readers about the input.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "readers/value_type.h"

namespace bcc4 {

// Frames to take, by the user's frame number: first, first + step, ... <= last.
struct FrameSelection {
  int64_t first = INT64_MIN;
  int64_t last = INT64_MAX;
  int64_t step = 1;
  bool given = false;
};
// Parses "A-B", "A-BxS", "A", "A-" or "-B".
[[nodiscard]] FrameSelection parse_frame_selection(std::string_view text);

enum class GapPolicy : uint8_t { error, hold, skip, interpolate };

struct ReaderOptions {
  std::vector<std::string> inputs;
  std::optional<std::array<uint64_t, 4>> dims; // x, y, z, t; t = 0: as many frames as files
  std::optional<Type> dtype;
  std::optional<bool> big_endian;
  std::optional<uint64_t> skip;    // bytes before the data of each raw file
  std::optional<uint64_t> count;   // arrays in each frame of a raw file
  std::optional<std::string> axes; // fastest first, such as "xyzt"; c: arrays (raw) or components (NRRD)
  std::optional<std::array<double, 3>> spacing, origin;
  std::optional<double> dt;
  std::optional<std::vector<double>> times;
  std::vector<std::string> grids;    // of OpenVDB files
  std::optional<bool> level_set_fog; // level sets of OpenVDB files: as fog; else as signed distances
  std::vector<std::string> channels; // arrays or components of other files
  FrameSelection frames;
  GapPolicy gaps = GapPolicy::error;
  uint64_t max_memory = 0; // bytes a reader may hold; 0: half of the machine's
};

// Bytes a reader may hold.
[[nodiscard]] uint64_t memory_limit(const ReaderOptions& options);

// An option that makes no sense for a format is an error and not ignored: throws, naming the first one that
// is set.
void refuse_raw_options(const ReaderOptions& options, const std::string& path, const char* format,
                        bool axes_allowed);
void refuse_grid_option(const ReaderOptions& options, const std::string& path, const char* format);
void refuse_channel_option(const ReaderOptions& options, const std::string& path, const char* format);

} // namespace bcc4
