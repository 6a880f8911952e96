#include "field/hyperplane.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {

Hyperplane::Hyperplane(double a, double b, double c, double d, double e) : coefficients_{a, b, c, d, e} {
  auto& h = coefficients_;
  for (const double v : h)
    if (!std::isfinite(v)) fail(Code::invalid_argument, "hyperplane: every coefficient must be finite");
  // Twice, as always: of oblique hyperplanes every third has other last digits after once, and files of
  // slices hold these digits.
  for (int pass = 0; pass < 2; ++pass) {
    // Scaled first, so that neither huge nor tiny normals overflow.
    const double largest = std::max({std::fabs(h[0]), std::fabs(h[1]), std::fabs(h[2]), std::fabs(h[3])});
    if (largest == 0) fail(Code::invalid_argument, "hyperplane: the normal (a, b, c, d) is zero");
    for (double& v : h) v /= largest;
    const double length = std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2] + h[3] * h[3]);
    for (double& v : h) v /= length;
    if (!std::isfinite(h[4])) fail(Code::invalid_argument, "hyperplane: the normal is too short for e");
  }
}

} // namespace bccsplat
