// SPDX-License-Identifier: Apache-2.0
#include "store/level_frames.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// Returns how often the frames of a level are halved along an axis: so often that they stay as fine as its
// lattice is.
int halvings(const FitOptions& options, int level, size_t axis) {
  return std::clamp(std::ilogb(options.scales[axis]), 0, level);
}

} // namespace

LevelFrames::LevelFrames(const std::vector<FitOptions>& levels, const Context& context) : context_(context) {
  std::array<int64_t, 3> dims{};
  for (size_t a = 0; a < 3; ++a) dims[a] = levels.front().dims[a];
  std::array<int, 3> done{};
  used_.push_back(0);
  for (int level = 1; level < static_cast<int>(levels.size()); ++level) {
    const FitOptions& options = levels[level];
    AxisFlags halved{}, predicted{};
    for (size_t a = 0; a < 3 && !options.lowpass; ++a) {
      halved[a] = dims[a] > 2 && halvings(options, level, a) > done[a];
      done[a] += halved[a] ? 1 : 0;
      predicted[a] = halved[a] && options.margins[a] > 0;
    }
    if (halved != AxisFlags{}) {
      halvers_.emplace_back(dims, halved, predicted, options.turning, options.fixed_predictions);
      dims = halvers_.back().dims();
    }
    used_.push_back(halvers_.size());
  }
  const auto& part = levels.front().part;
  if (part && !part->counted.all_space()) make_block_only(levels);
}

// What a halved frame is needed for: the levels that are resampled from it, and the next halved frame.
void LevelFrames::make_block_only(const std::vector<FitOptions>& levels) {
  for (size_t halved = halvers_.size() + 1; halved-- > 0;) {
    Region needed;
    const auto& n = levels.front().dims;
    const std::array<int64_t, 3> dims =
        halved > 0 ? halvers_[halved - 1].dims() : std::array<int64_t, 3>{n[0], n[1], n[2]};
    for (size_t level = 1; level < levels.size(); ++level)
      if (used_[level] == halved)
        needed = needed.joined(seen_samples(levels[level], lattice_of(levels[level], n[3]), dims));
    if (halved < halvers_.size()) needed = needed.joined(halvers_[halved].seen());
    if (halved == 0)
      seen_ = needed;
    else
      halvers_[halved - 1].make_only(needed);
  }
}

LevelFrames::Images::Images(LevelFrames& frames, const PreparedFrame& source, float ringing)
    : frames_(frames), source_(source) {
  halved_.reserve(frames.halvers_.size());
  for (FrameHalver& halver : frames.halvers_) {
    const bool first = halved_.empty();
    const Frame& from = first ? source.frame : *halved_.back().frame;
    const CellRanges& cells = first ? source.scan.cells : halved_.back().cells;
    halved_.push_back(halver.halve(from, cells, source.faces, ringing, frames.context_));
  }
}

FrameImage LevelFrames::Images::at(int level) const {
  const size_t used = frames_.used_[level];
  if (used == 0) return {source_.frame, source_.scan.cells, source_.faces};
  return {*halved_[used - 1].frame, halved_[used - 1].cells, source_.faces};
}

} // namespace bccsplat
