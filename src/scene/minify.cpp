// SPDX-License-Identifier: Apache-2.0
#include "scene/minify.h"

#include <algorithm>
#include <cmath>

#include "slice/coarsen.h"
#include "view/sheet_metric.h"

namespace bccsplat {

const CoarseLevels::Level& CoarseLevels::level(const Slice& base, int n, const Context& context) const {
  const std::scoped_lock lock(mutex_);
  while (levels_.size() < static_cast<size_t>(n)) {
    auto level = std::make_unique<Level>();
    level->slice = coarsen(levels_.empty() ? base : levels_.back()->slice, context);
    level->memory = Reservation(context.memory, level->slice.bytes(), "a coarser slice");
    levels_.push_back(std::move(level));
  }
  return *levels_[static_cast<size_t>(n) - 1];
}

void CoarseLevels::place(const Affine3& slice_to_world) {
  for (const auto& level : levels_) level->slice.slice_to_world = slice_to_world;
}

int minification_level(const Slice& slice, const SliceView& seen) {
  const SheetView view = seen.sheets(1);
  // The size of a pixel at the centre of the domain, in the direction where it is smallest; it is negative
  // with the centre behind the eye.
  const double pixel = view.scale(0) * SheetMetric(view).extremes()[0];
  constexpr double rounding = 1e-9; // of the size of a pixel, which is often meant to be a power of two
  constexpr int32_t fewest = 4;
  const int32_t planes = *std::min_element(slice.lattice.last.begin(), slice.lattice.last.end());
  int level = 0;
  while (pixel >= std::ldexp(1 - rounding, level + 1) && planes >> (level + 1) >= fewest) ++level;
  return level;
}

} // namespace bccsplat
