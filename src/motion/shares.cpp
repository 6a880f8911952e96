// SPDX-License-Identifier: Apache-2.0
#include "motion/shares.h"

#include <algorithm>

namespace bccsplat::motion {
namespace {

constexpr double furthest_frame = 1.5; // of the interval: where ways are straight no longer

// The polynomial through frames first .. end-1.
std::vector<Share> polynomial(std::span<const double> times, double time, size_t first, size_t end,
                              double length) {
  std::vector<Share> shares;
  for (size_t i = first; i < end; ++i) {
    double weight = 1;
    for (size_t j = first; j < end; ++j)
      if (j != i) weight *= (time - times[j]) / (times[i] - times[j]);
    shares.push_back({i, static_cast<float>(weight), static_cast<float>((times[i] - time) / length)});
  }
  return shares;
}

} // namespace

size_t interval_of(std::span<const double> times, double time) {
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  const auto i = static_cast<size_t>(std::max<std::ptrdiff_t>(after - times.begin() - 1, 0));
  return std::min(i, times.size() - 2);
}

float before_middle(std::span<const double> times, double time) {
  const size_t i = interval_of(times, time);
  return static_cast<float>(.5 - (time - times[i]) / (times[i + 1] - times[i]));
}

std::vector<Share> cubic_shares(std::span<const double> times, double time) {
  const size_t i = interval_of(times, time);
  const double length = times[i + 1] - times[i];
  const bool before = i > 0 && times[i] - times[i - 1] <= furthest_frame * length;
  const bool behind = i + 2 < times.size() && times[i + 2] - times[i + 1] <= furthest_frame * length;
  return polynomial(times, time, before ? i - 1 : i, behind ? i + 3 : i + 2, length);
}

std::vector<Share> linear_shares(std::span<const double> times, double time) {
  const size_t i = interval_of(times, time);
  return polynomial(times, time, i, i + 2, times[i + 1] - times[i]);
}

} // namespace bccsplat::motion
