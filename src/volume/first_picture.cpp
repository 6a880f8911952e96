// SPDX-License-Identifier: Apache-2.0
#include "volume/first_picture.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

constexpr double as_good = 0.95; // of the widest span: noise moves the ends of ranges

} // namespace

uint32_t frame_that_shows_most(const std::vector<Range>& ranges) {
  double widest = 0;
  for (const Range& r : ranges) widest = std::max(widest, r.high - r.low);
  const double middle = (static_cast<double>(ranges.size()) - 1) / 2;
  size_t best = 0;
  double nearest = HUGE_VAL;
  for (size_t i = 0; i < ranges.size(); ++i) {
    const double away = std::fabs(static_cast<double>(i) - middle);
    if (ranges[i].high - ranges[i].low >= as_good * widest && away < nearest) best = i, nearest = away;
  }
  return static_cast<uint32_t>(best);
}

FirstPicture first_picture(const OpenVolume& volume, uint32_t channel, series::DataKind kind) {
  const VolumeInfo& v = volume.info();
  FirstPicture first{kind_look(kind).layout, 0};
  if (v.part) { // planes of a part would lie beside it
    first.layout = Layout::volume;
    first.frame = static_cast<uint32_t>(v.part->block.first_frame());
    return first;
  }
  // What is one sample thick is a plane as it is.
  for (size_t a = 0; a < 3 && first.layout != Layout::flat; ++a)
    if (v.lattice.dims[a] == 1) first.layout = Layout::volume;
  std::vector<Range> ranges = volume.channel(channel).frames;
  ranges.resize(std::min<size_t>(ranges.size(), v.lattice.dims[3]));
  first.frame = frame_that_shows_most(ranges);
  return first;
}

} // namespace bccsplat
