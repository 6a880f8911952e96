// SPDX-License-Identifier: Apache-2.0
// A part of a series small enough to be tried out: boxes of it, through stretches of frames, picked where the
// series is busy, and what each of them stands for.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "series/frame_reader.h"
#include "series/scan.h"
#include "series/watch.h"

namespace bccsplat::series {

// A box of some frames. Where it ends inside the series it is wider than the part it stands for: there a
// lattice would be mirrored as it is not in the series.
struct SampleStretch {
  uint64_t first = 0, frames = 0; // of the series
  SampleBox box;
  SampleBox inner;      // the part that counts, in samples of the series
  FrameSpan counts;     // frames of the series
  FrameSpan stands_for; // the same: all that no other stretch stands for
  uint64_t ends = 0;    // of the frames that count, the last ones, where the series ends: they stand for
                        // themselves
  double weight = 1;    // a mean over the series is the sum of these times the means over the inner parts
  double filled = 0;    // by these weights, of what the series has that is not air; 0: not counted
  std::vector<std::vector<float>> values; // by channel: x fastest, frames slowest; NaN as in the source

  // Returns how many frames one that counts stands for.
  [[nodiscard]] double frame_weight(uint64_t frame) const;
  // Is the box as long as the series along this axis?
  [[nodiscard]] bool whole(size_t axis, const std::array<uint64_t, 4>& dims) const {
    return axis == 3 ? frames == dims[3] : box.dims[axis] == dims[axis];
  }
};

struct SeriesSample {
  std::vector<SampleStretch> stretches;
  std::vector<ChannelScan> ranges; // by channel: of the frames that were looked at to find what is busy, and
                                   // of the boxes
  [[nodiscard]] uint64_t frames() const;
  // Returns what is not air by the weights, over what there is of it: the factor that rounding is off by.
  [[nodiscard]] double filled() const;
};

// A larger sample takes longer, a smaller one is less like the file (what it predicted of real series:
// tests/bench/notes/lattice-fit.md). The default is for what must hold, the error that somebody accepts.
struct SampleSize {
  uint64_t samples = uint64_t{5} << 19; // per channel, or a little more; a series of that size is taken whole
  uint64_t edge = 26;                   // of a box, at most, along x, y, z
  uint64_t frames = 32;                 // of a stretch
};

// A 128th of a series, between limits: enough to tell which lattice is better, in a part of the time that the
// import takes.
[[nodiscard]] SampleSize size_to_choose(const std::array<uint64_t, 4>& dims);

// Reads the frames it needs. air: by channel.
[[nodiscard]] SeriesSample sample_series(FrameReader& reader, const std::vector<double>& air,
                                         const SampleSize& size, Watch& watch);

// The series that a stretch is by itself: dims, times and types replaced.
[[nodiscard]] SeriesDescription describe_stretch(const SeriesDescription& series,
                                                 const SampleStretch& stretch);

} // namespace bccsplat::series
