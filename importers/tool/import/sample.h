// A part of a series small enough to be tried out: stretches of frames, cut to a box around what is not air.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "readers/frame_reader.h"

namespace bcc4 {

struct SampleStretch {
  uint64_t first = 0, frames = 0; // of the series
  SampleBox box;
  std::vector<std::vector<float>> values; // by channel: x fastest, frames slowest; NaN as in the source
};

// The default decides the coding: a larger sample takes longer, a smaller one is less like the file
// (what it chose on real series: tests/bench/notes/fit.md).
struct SampleSize {
  uint64_t edge = 64;     // at most so many samples along x, y, z
  uint64_t frames = 12;   // of a stretch
  uint64_t stretches = 2; // evenly spread; one with all frames where the series is short
};

// Reads the frames it needs, in order. air: by channel.
[[nodiscard]] std::vector<SampleStretch> sample_series(FrameReader& reader, const std::vector<double>& air,
                                                       const SampleSize& size);

// The series that a stretch is by itself: dims, times and types replaced.
[[nodiscard]] SeriesDescription describe_stretch(const SeriesDescription& series,
                                                 const SampleStretch& stretch);

} // namespace bcc4
