// SPDX-License-Identifier: Apache-2.0
// Which frames of a source become which frames of the series: selection, gaps, times.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// Frame (1 - weight) * a + weight * b of the source.
struct PlannedFrame {
  uint64_t a = 0, b = 0;
  double weight = 0;
  int64_t number = 0; // as the user counts
};

struct FramePlan {
  std::vector<PlannedFrame> frames;
  std::vector<std::string> gaps; // in words
  int64_t stride = 1;            // numbers of neighbouring frames of the source are this far apart
  bool times_by_number = false;  // where the source has none: for numbers that are further apart than 1
  std::vector<double> decimals;  // in the names of the source's files; the same
};

// Plans one source frame per file. Throws for a gap under GapPolicy::error, naming the missing numbers.
[[nodiscard]] FramePlan plan_files(const Sequence& sequence, const ReaderOptions& options);
inline constexpr uint64_t most_frames = uint64_t{1} << 22;
// Refuses a declared number of frames that no real series has, before memory is taken for each.
void check_frame_count(uint64_t count, const std::string& path);
// Plans the frames 0 .. count - 1 of one source.
[[nodiscard]] FramePlan plan_selection(uint64_t count, const FrameSelection& selection,
                                       const std::string& path);

// Plans `count` frames of one file, or of several files that hold one each: then a frame is known by its
// file's number.
[[nodiscard]] FramePlan plan_frames(const Sequence& sequence, uint64_t count, const ReaderOptions& options);

// Returns the series as planned. Times are the user's, or those of the source, or by the user's step from the
// source's first one on; a source without times begins at 0 or has the frame index. They rise strictly or it
// throws. --spacing replaces the affine, --origin its translation.
[[nodiscard]] std::unique_ptr<FrameReader> planned_series(std::unique_ptr<FrameReader> source, FramePlan plan,
                                                          const ReaderOptions& options);

} // namespace bcc4
