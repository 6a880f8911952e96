// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/bars.h"

#include <algorithm>

#include "tool/annotate/ticks.h"
#include "tool/view/time_slice.h"

namespace bcc4 {

ColorBar surface_bar(const std::string& heading, std::vector<bccsplat_iso_surface> surfaces,
                     const std::vector<std::array<double, 4>>& colors) {
  std::erase_if(surfaces, [](const auto& s) { return s.opacity == 0; });
  std::sort(surfaces.begin(), surfaces.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  ColorBar bar{heading, {}};
  for (size_t n = 0; n < surfaces.size(); ++n) {
    const bccsplat_iso_surface& s = surfaces[n];
    const Color color = s.use_color ? Color{s.color[0], s.color[1], s.color[2]} : color_at(colors, s.value);
    const auto low = static_cast<double>(n);
    for (const double end : {low, low + 1}) bar.colors.push_back({end, color[0], color[1], color[2]});
    bar.ticks.push_back(low + 0.5);
    const std::string passes = s.opacity < 1 ? concat(" (", short_number(100 * s.opacity, 2), "%)") : "";
    bar.texts.push_back(short_number(s.value, 4) + passes);
  }
  if (bar.colors.empty()) bar.colors.push_back({0, 0, 0, 0}), bar.ticks = {0}, bar.texts = {"none"};
  return bar;
}

ColorBar label_bar(const std::string& heading, const std::vector<std::array<double, 4>>& colors) {
  const size_t count = colors.size() / 2;
  ColorBar bar{heading, std::vector<std::array<double, 4>>(2 * count), std::vector<double>(count),
               std::vector<std::string>(count)};
  double label = 0;
  for (size_t n = count; n-- > 0;) {
    const double end = colors[2 * n + 1][0];
    label = n + 1 == count ? end - 0.5 : 2 * end - label;
    const auto low = static_cast<double>(n);
    bar.colors[2 * n] = bar.colors[2 * n + 1] = colors[2 * n];
    bar.colors[2 * n][0] = low, bar.colors[2 * n + 1][0] = low + 1;
    bar.ticks[n] = low + 0.5, bar.texts[n] = short_number(label, 6);
  }
  return bar;
}

std::vector<double> trail_colors(uint32_t intervals) {
  constexpr Color cold{0.05, 0.2, 1}, middle{0.9, 0.9, 0.9}, warm{1, 0.3, 0.02};
  std::vector<double> out;
  for (uint32_t n = 0; n < intervals; ++n) {
    const double x = intervals > 1 ? 2.0 * n / (intervals - 1) - 1 : 0; // -1 .. 1
    for (size_t c = 0; c < 3; ++c)
      out.push_back(x < 0 ? (1 + x) * middle[c] - x * cold[c] : (1 - x) * middle[c] + x * warm[c]);
  }
  return out;
}

std::optional<ColorBar> trail_bar(const RenderArguments& a, const Volume& volume, const Cut& where,
                                  const std::array<double, 2>& interval) {
  if (!a.trail || a.trail->intervals < 2 || !where.is_time_slice) return std::nullopt;
  // Sub-intervals that have no colour of their own.
  if (trail_tf_files(a).size() > 1 || !a.shutter.empty()) return std::nullopt;
  const bccsplat_volume_info info = volume_info(volume);
  const bool periodic = info.time_periodic, frames = periodic || a.trail->frames || a.which.index || a.frames;
  std::array<double, 2> clipped = interval;
  if (!periodic)
    for (double& end : clipped)
      end = std::clamp(end, -where.index, static_cast<double>(info.dims[3] - 1) - where.index);
  if (!(clipped[1] > clipped[0])) return std::nullopt;
  const std::string unit = frames ? "frames" : info.time_unit;
  ColorBar bar{unit.empty() ? "trail" : concat("trail [", unit, "]"), {}};
  const std::vector<double> color = trail_colors(a.trail->intervals);
  const auto edge = [&](uint32_t n) {
    const double offset = clipped[0] + (clipped[1] - clipped[0]) * n / a.trail->intervals;
    return frames ? offset : cut_at_index(volume, where.index + offset).time - where.time;
  };
  for (uint32_t n = 0; n <= a.trail->intervals; ++n) {
    bar.ticks.push_back(edge(n));
    if (n == a.trail->intervals) break;
    for (const double end : {edge(n), edge(n + 1)})
      bar.colors.push_back({end, color[3 * n], color[3 * n + 1], color[3 * n + 2]});
  }
  bar.texts = tick_texts(bar.ticks);
  return bar;
}

} // namespace bcc4
