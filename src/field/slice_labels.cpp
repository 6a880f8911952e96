// SPDX-License-Identifier: Apache-2.0
#include "field/slice_labels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "field/masks.h"

namespace bccsplat {

SliceLabels::SliceLabels(const Vec3& origin, const Int3& samples, std::vector<float> values,
                         Reservation memory, EvenPlaces even)
    : origin_(origin), samples_(samples), values_(std::move(values)), memory_(std::move(memory)),
      even_(std::move(even)) {}

int32_t SliceLabels::nearest(size_t axis, double place) const {
  if (!even_.uneven(axis)) return static_cast<int32_t>(nearest_sample(place - origin_[axis], samples_[axis]));
  const int64_t sample = even_.axes->nearest_sample(even_.along[axis], place) - std::llround(origin_[axis]);
  return static_cast<int32_t>(std::clamp<int64_t>(sample, 0, samples_[axis] - 1));
}

} // namespace bccsplat
