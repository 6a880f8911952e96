// SPDX-License-Identifier: Apache-2.0
// Where a series changes: what finds the parts of it that tell most about the errors of a lattice.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "series/frame_reader.h"
#include "series/scan.h"
#include "series/watch.h"

namespace bccsplat::series {

// Cells of about equal size that divide an axis of n samples, and boxes around them, all of one size.
struct Division {
  uint64_t n = 1, cells = 1, margin = 0;
  // Boxes of at most `longest` samples; without cuts there is no border.
  Division(uint64_t samples, uint64_t longest, uint64_t border);
  [[nodiscard]] uint64_t begin(uint64_t cell) const { return n * cell / cells; }
  [[nodiscard]] uint64_t cell_at(uint64_t i) const { return ((i + 1) * cells - 1) / n; }
  [[nodiscard]] FrameSpan counts(uint64_t cell) const { return {begin(cell), begin(cell + 1)}; }
  [[nodiscard]] FrameSpan box(uint64_t cell) const;
};
using Divisions = std::array<Division, 3>;
[[nodiscard]] inline size_t cells_of(const Divisions& axes) {
  return axes[0].cells * axes[1].cells * axes[2].cells;
}

// What cells have of something, x fastest.
using Shares = std::vector<double>;

// What the errors of a lattice rise with: changes from sample to sample where a coarse one loses them, in two
// axes at once; bends from one frame to the next; kinks where a face mirrors what goes on behind it, along
// axes that are divided. What is not air: there are the errors of rounding.
struct Activity {
  Shares in_space, in_time, at_faces, filled;
  explicit Activity(size_t cells) : in_space(cells), in_time(cells), at_faces(cells), filled(cells) {}
};

// Returns what the cells have in the mean frame of `here`, all of them together 1 in the mean frame of `all`,
// which holds `here`. Channels count alike. Looks at some frames of both; ranges: widened by what is seen, by
// channel.
[[nodiscard]] Activity find_activity(FrameReader& reader, const std::vector<double>& air,
                                     const Divisions& axes, FrameSpan here, FrameSpan all,
                                     std::vector<ChannelScan>& ranges, Watch& watch);

} // namespace bccsplat::series
