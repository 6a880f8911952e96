// SPDX-License-Identifier: Apache-2.0
#include "tool/view/shown_values.h"

#include <algorithm>
#include <iterator>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr double visible = 1e-3;      // an opacity
constexpr double next_to_none = 1e-5; // of the samples

double opacity_at(const std::vector<std::array<double, 2>>& points, double value) {
  const auto above = std::find_if(points.begin(), points.end(), [&](const auto& p) { return p[0] > value; });
  if (above == points.begin()) return points.front()[1];
  if (above == points.end()) return points.back()[1];
  const auto& [v0, o0] = *std::prev(above);
  const auto& [v1, o1] = *above;
  return o0 + (o1 - o0) * (value - v0) / (v1 - v0);
}

} // namespace

std::optional<std::string> shows_nothing(const std::vector<std::array<double, 2>>& opacities,
                                         const bccsplat_channel_info& c) {
  if (opacities.empty()) return std::nullopt;
  const size_t bins = std::size(c.histogram);
  const double width = (c.kept_range[1] - c.kept_range[0]) / static_cast<double>(bins);
  double all = 0, shown = 0;
  for (size_t i = 0; i < bins; ++i) {
    const auto n = static_cast<double>(c.histogram[i]);
    const double low = c.kept_range[0] + static_cast<double>(i) * width;
    all += n;
    // A function may be narrower than a bin.
    bool seen = opacity_at(opacities, low) > visible || opacity_at(opacities, low + width) > visible;
    for (const auto& [value, opacity] : opacities)
      seen = seen || (value >= low && value <= low + width && opacity > visible);
    if (seen) shown += n;
  }
  if (all == 0 || shown > next_to_none * all) return std::nullopt;
  const auto first =
      std::find_if(opacities.begin(), opacities.end(), [](const auto& p) { return p[1] > visible; });
  if (first == opacities.end()) return "nothing is shown: all is transparent";
  return concat("nothing is shown: the values run from ", short_number(c.kept_range[0], 3), " to ",
                short_number(c.kept_range[1], 3), ", and what is visible is near ",
                short_number((*first)[0], 3));
}

} // namespace bcc4
