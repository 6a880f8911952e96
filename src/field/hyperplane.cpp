// SPDX-License-Identifier: Apache-2.0
#include "field/hyperplane.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

void normalise(std::array<double, 5>& h) {
  for (const double v : h)
    if (!std::isfinite(v)) fail(Code::invalid_argument, "hyperplane: every coefficient must be finite");
  // Scaled first, so that neither huge nor tiny normals overflow.
  const double largest = std::max({std::fabs(h[0]), std::fabs(h[1]), std::fabs(h[2]), std::fabs(h[3])});
  if (largest == 0) fail(Code::invalid_argument, "hyperplane: the normal (a, b, c, d) is zero");
  for (double& v : h) v /= largest;
  const double length = std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2] + h[3] * h[3]);
  for (double& v : h) v /= length;
  if (!std::isfinite(h[4])) fail(Code::invalid_argument, "hyperplane: the normal is too short for e");
}

} // namespace

Hyperplane::Hyperplane(const std::array<double, 5>& coefficients) : coefficients_(coefficients) {
  normalise(coefficients_);
}

// Coefficients are normalised twice: after one pass every third oblique hyperplane has other last digits than
// after two, and files of slices hold the latter.
Hyperplane::Hyperplane(double a, double b, double c, double d, double e)
    : Hyperplane(std::array<double, 5>{a, b, c, d, e}) {
  normalise(coefficients_);
}

Hyperplane Hyperplane::through(const Vec4& point, const Vec4& normal) {
  const double e =
      -(normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] + normal[3] * point[3]);
  return Hyperplane(std::array<double, 5>{normal[0], normal[1], normal[2], normal[3], e});
}

} // namespace bccsplat
