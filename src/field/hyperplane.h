// SPDX-License-Identifier: Apache-2.0
// A hyperplane of a 4D space: index space, unless said otherwise.
#pragma once

#include <array>
#include <cstddef>

#include "base/vec.h"

namespace bccsplat {

// a x + b y + c z + d t + e = 0. The normal (a, b, c, d) has unit length from the start, so nobody else
// normalises it.
class Hyperplane {
 public:
  // Coefficients of any length. Throws invalid_argument for a normal that is zero or not finite.
  Hyperplane(double a, double b, double c, double d, double e);
  // Through a point, normal to a direction that has unit length up to rounding.
  [[nodiscard]] static Hyperplane through(const Vec4& point, const Vec4& normal);

  [[nodiscard]] double operator[](size_t i) const { return coefficients_[i]; } // a, b, c, d, e
  [[nodiscard]] const std::array<double, 5>& coefficients() const { return coefficients_; }
  [[nodiscard]] Vec4 normal() const {
    return {coefficients_[0], coefficients_[1], coefficients_[2], coefficients_[3]};
  }
  // The parallel one that lies `distance` further along the normal.
  [[nodiscard]] Hyperplane moved(double distance) const {
    Hyperplane other = *this;
    other.coefficients_[4] -= distance;
    return other;
  }

 private:
  explicit Hyperplane(const std::array<double, 5>& coefficients);

  std::array<double, 5> coefficients_;
};

// Signed distance of a point.
[[nodiscard]] inline double height(const Hyperplane& h, const Vec4& p) {
  return h[0] * p[0] + h[1] * p[1] + h[2] * p[2] + h[3] * p[3] + h[4];
}

} // namespace bccsplat
