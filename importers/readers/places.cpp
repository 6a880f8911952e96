// SPDX-License-Identifier: Apache-2.0
#include "readers/places.h"

#include <cmath>

namespace bcc4 {
namespace {

constexpr double kPartOfStep = 1e-3; // places that differ by less are one

} // namespace

double mean_step(const std::vector<double>& at) {
  return at.size() < 2 ? 0 : (at.back() - at.front()) / static_cast<double>(at.size() - 1);
}

std::vector<double> even_positions(const std::vector<double>& at) {
  const double step = mean_step(at);
  std::vector<double> positions;
  for (const double place : at) positions.push_back((place - at.front()) / step);
  return positions;
}

bool evenly_spaced(const std::vector<double>& at) {
  const double step = mean_step(at);
  bool even = step != 0 && std::isfinite(step);
  for (size_t i = 0; i < at.size(); ++i)
    even = even && std::abs(at[i] - (at[0] + static_cast<double>(i) * step)) <= kPartOfStep * std::abs(step);
  return even;
}

bool strictly_monotonic(const std::vector<double>& at) {
  const double sign = at.back() < at.front() ? -1 : 1;
  for (size_t i = 0; i < at.size(); ++i)
    if (!std::isfinite(at[i]) || (i > 0 && !(sign * at[i] > sign * at[i - 1]))) return false;
  return true;
}

} // namespace bcc4
