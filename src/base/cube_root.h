// SPDX-License-Identifier: Apache-2.0
// The cube root, the same on every machine: those of the systems differ in the last bit.
#pragma once

#include <cmath>
#include <initializer_list>

namespace bccsplat {

// Returns x - y^3 with an error far below the last bit of x, where the two are close. Products of halves are
// exact, as not every system's std::fma is.
[[nodiscard]] inline double cube_rest(double x, double y) {
  constexpr double split = 134217729; // 2^27 + 1
  const auto low_of_product = [](double a, double b, double product) {
    const double big_a = a * split, big_b = b * split;
    const double a1 = big_a - (big_a - a), b1 = big_b - (big_b - b), a2 = a - a1, b2 = b - b1;
    return ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
  };
  const double square = y * y, cube = square * y;
  return (x - cube) - (low_of_product(square, y, cube) + low_of_product(y, y, square) * y);
}

// Returns the number whose cube is nearest, of magnitudes between 1e-90 and 1e90.
[[nodiscard]] inline double cube_root(double x) {
  const double first = std::cbrt(x); // off by as much as four last bits
  if (first == 0) return first;
  const double guess = first + cube_rest(x, first) / (3 * first * first);
  double best = guess;
  for (const double y : {std::nextafter(guess, 0.0), std::nextafter(guess, 2 * guess)})
    if (std::fabs(cube_rest(x, y)) < std::fabs(cube_rest(x, best))) best = y;
  return best;
}

} // namespace bccsplat
