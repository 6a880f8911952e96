// SPDX-License-Identifier: Apache-2.0
#include "field/slice_labels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "field/masks.h"

namespace bccsplat {

SliceLabels::SliceLabels(const Vec3& origin, const Int3& samples, std::vector<float> values,
                         Reservation memory)
    : origin_(origin), samples_(samples), values_(std::move(values)), memory_(std::move(memory)) {}

int32_t SliceLabels::nearest(size_t axis, double place) const {
  return static_cast<int32_t>(nearest_sample(place - origin_[axis], samples_[axis]));
}

} // namespace bccsplat
