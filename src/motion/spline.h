// SPDX-License-Identifier: Apache-2.0
// A frame between its samples: the cubic spline through them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "motion/box.h"
#include "motion/nodes.h"

namespace bccsplat::motion {

class Spline {
 public:
  explicit Spline(const Box& box);

  [[nodiscard]] const Int3& dims() const { return dims_; }
  // Outside it has the value of the nearest place inside.
  [[nodiscard]] float value(const Float3& place) const;
  // The value, and in gradient what it changes by per sample.
  [[nodiscard]] float value_and_gradient(const Float3& place, Float3& gradient) const;

 private:
  Int3 dims_;
  size_t row_, plane_;              // from one row, and plane, of coefficients to the next
  std::vector<float> coefficients_; // one more before each axis, two behind it
};

} // namespace bccsplat::motion
