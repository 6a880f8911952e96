// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/color_bar.h"

#include <algorithm>
#include <cmath>

#include "tool/annotate/font.h"
#include "tool/annotate/ticks.h"

namespace bcc4 {
namespace {

constexpr size_t most_ticks = 9;
constexpr double tick_distance = 1.9; // at least, in em
constexpr double digit_height = 0.73; // of the font's em

// Picks ticks so far apart that there is room for them; the first is one of them.
std::vector<size_t> fitting_ticks(size_t count, size_t fitting) {
  const size_t apart = count > fitting ? (count - 2) / (fitting - 1) + 1 : 1;
  std::vector<size_t> out;
  for (size_t n = 0; n < count; n += apart) out.push_back(n);
  return out;
}

} // namespace

Color color_at(const std::vector<std::array<double, 4>>& colors, double value) {
  const auto above = std::find_if(colors.begin(), colors.end(), [&](const auto& c) { return c[0] > value; });
  const auto& to = above == colors.end() ? colors.back() : *above;
  const auto& from = above == colors.begin() ? to : *(above - 1);
  const double t = to[0] > from[0] ? std::clamp((value - from[0]) / (to[0] - from[0]), 0.0, 1.0) : 0;
  Color out;
  for (size_t i = 0; i < 3; ++i) out[i] = from[i + 1] + t * (to[i + 1] - from[i + 1]);
  return out;
}

void draw_color_bar(Canvas& canvas, const ColorBar& bar, const Point& corner, double width, double height,
                    double em, const Ink& ink) {
  canvas.text(fitted_text(bar.heading, em, width), {corner[0], corner[1] + em}, em, Anchor::right, ink);
  const double low = bar.colors.front()[0], high = bar.colors.back()[0];
  const double top = std::round(corner[1] + 1.8 * em), frame = std::max(1.0, std::round(em / 20));
  const double length = high > low ? std::round(height - 2.3 * em) : std::round(em);
  const auto fitting = static_cast<size_t>(std::max(2.0, length / (tick_distance * em)));
  std::vector<double> ticks = bar.ticks;
  std::vector<std::string> texts = bar.texts;
  if (ticks.empty()) {
    ticks = round_ticks(low, high, std::min(most_ticks, fitting));
    texts = tick_texts(ticks);
  }
  double widest = 0;
  for (const std::string& text : texts) widest = std::max(widest, text_width(text, em));
  // The bar stands left of its numbers.
  const double right = std::round(corner[0] - widest - 0.6 * em), left = right - std::round(em);
  canvas.fill({left - frame, top - frame}, {right + frame, top + length + frame}, ink.color);
  for (double y = 0; y < length; ++y) {
    const double value = high - (high - low) * (y + 0.5) / length;
    canvas.fill({left, top + y}, {right, top + y + 1}, color_at(bar.colors, value));
  }
  for (const size_t i : fitting_ticks(ticks.size(), bar.ticks.empty() ? ticks.size() : fitting)) {
    const double share = high > low ? (high - ticks[i]) / (high - low) : 0.5, y = top + share * length;
    const double line = std::round(std::clamp(y - frame / 2, top, top + length - frame));
    canvas.fill({right, line}, {right + 0.35 * em, line + frame}, ink.color);
    canvas.text(texts[i], {corner[0] - widest, y + digit_height / 2 * em}, em, Anchor::left, ink);
  }
}

} // namespace bcc4
