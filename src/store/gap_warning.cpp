// SPDX-License-Identifier: Apache-2.0
#include "store/gap_warning.h"

#include <algorithm>
#include <vector>

#include "base/text.h"

namespace bccsplat {
namespace {

constexpr double wide = 3; // usual steps

} // namespace

std::string gap_warning(std::span<const double> times, std::span<const uint32_t> measured) {
  if (times.size() < 3) return {};
  std::vector<double> steps;
  for (size_t n = 1; n < times.size(); ++n) steps.push_back(times[n] - times[n - 1]);
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double usual = *middle;
  const auto is_measured = [&](size_t frame) {
    return std::binary_search(measured.begin(), measured.end(), static_cast<uint32_t>(frame));
  };
  size_t gap = steps.size();
  for (size_t n = 0; n < steps.size(); ++n)
    if (steps[n] > wide * usual && !(is_measured(n) && is_measured(n + 1)) &&
        (gap == steps.size() || steps[n] > steps[gap]))
      gap = n;
  if (gap == steps.size()) return {};
  return concat(
      "frames ", gap, " and ", gap + 1, " are ", steps[gap], " apart, others ", usual,
      ": values near such a gap may be far off, and were not measured there; give dims[3] (the most "
      "frames that may come, and end with finish_short) with abs_error or MEASURE_ALL, or make a "
      "file of either side");
}

} // namespace bccsplat
