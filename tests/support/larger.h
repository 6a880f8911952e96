// SPDX-License-Identifier: Apache-2.0
// The largest of differences: unlike with std::max, one that is not a number is never passed over.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <ranges>

namespace bccsplat {

// The larger of the two; infinity where either is not a number.
inline double larger(double most, double value) {
  return std::isnan(most) || std::isnan(value) ? std::numeric_limits<double>::infinity()
                                               : std::max(most, value);
}

// The largest absolute difference of elements at the same place. Infinity where one is not a number, where
// the ranges are of different lengths, and where both are empty: then nothing was compared.
template<std::ranges::random_access_range A, std::ranges::random_access_range B>
double largest_difference(const A& a, const B& b) {
  const size_t count = std::ranges::size(a);
  if (count == 0 || count != std::ranges::size(b)) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (size_t i = 0; i < count; ++i)
    most = larger(most, std::fabs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
  return most;
}

} // namespace bccsplat
