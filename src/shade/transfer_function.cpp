// SPDX-License-Identifier: Apache-2.0
// Evaluates transfer functions and makes the tables that sheets are classified by.
#include "shade/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/error.h"

namespace bccsplat {
namespace {

constexpr double brightest = 1e9; // more, lit and summed in single precision, would come to no number

// Returns the index of the last point at or before `value`, -1 before the first; points rise.
template<class Points> std::ptrdiff_t segment(const Points& points, double value) {
  const auto after = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const auto& p) { return v < p.value; });
  return after - points.begin() - 1;
}

// Returns the position of `value` between points n and n + 1, in [0, 1].
template<class Points> double between(const Points& points, size_t n, double value) {
  return (value - points[n].value) / (points[n + 1].value - points[n].value);
}

template<class Points> void check_values(const Points& points, const char* what) {
  if (points.empty()) fail(Code::invalid_argument, "transfer function: no ", what, " points");
  for (size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].value))
      fail(Code::invalid_argument, "transfer function: ", what, " point ", i, " has no finite value");
    if (i > 0 && points[i].value < points[i - 1].value)
      fail(Code::invalid_argument, "transfer function: the values of ", what, " points must rise; point ", i,
           " falls from ", points[i - 1].value, " to ", points[i].value);
  }
}

} // namespace

void TransferFunction::check() const {
  check_values(colors, "colour");
  check_values(opacities, "opacity");
  for (const ColorPoint& p : colors)
    for (const double c : p.color)
      if (!(c >= 0 && c <= brightest))
        fail(Code::invalid_argument, "transfer function: a colour of ", c, " is not in 0 .. ", brightest);
  for (const OpacityPoint& p : opacities)
    if (!(p.opacity >= 0 && p.opacity <= 1))
      fail(Code::invalid_argument, "transfer function: opacity ", p.opacity, " is outside [0, 1]");
  if (!(unit_distance >= 0 && std::isfinite(unit_distance)))
    fail(Code::invalid_argument, "transfer function: unit_distance must be finite and not negative");
}

Vec3 TransferFunction::color(double value) const {
  const std::ptrdiff_t n = segment(colors, value);
  if (n < 0) return colors.front().color;
  const size_t i = n;
  if (i + 1 == colors.size()) return colors.back().color;
  const double f = between(colors, i, value);
  return (1 - f) * colors[i].color + f * colors[i + 1].color;
}

double TransferFunction::opacity(double value) const {
  const std::ptrdiff_t n = segment(opacities, value);
  if (n < 0) return opacities.front().opacity;
  const size_t i = n;
  if (i + 1 == opacities.size()) return opacities.back().opacity;
  const double f = between(opacities, i, value);
  return (1 - f) * opacities[i].opacity + f * opacities[i + 1].opacity;
}

double extinction(double opacity, double unit_distance) {
  // exp(-opaque x) is 0 for any path x longer than 1e-7 unit distances.
  constexpr double opaque = 1e9;
  return (opacity < 1 ? -std::log1p(-opacity) : opaque) / unit_distance;
}

ClassTable make_class_table(const TransferFunction& function, double low, double high, double anchor,
                            double unit_distance, int entries) {
  ClassTable table;
  // No entry is spent outside the function's own points, where nothing changes.
  const double from = std::min(function.colors.front().value, function.opacities.front().value);
  const double to = std::max(function.colors.back().value, function.opacities.back().value);
  double a = std::clamp(from, low, high), b = std::clamp(to, low, high);
  table.unit_distance = static_cast<float>(unit_distance);
  // A scale is a float, so that values that lie closer together share an entry.
  const double most = (b - a) * std::numeric_limits<float>::max();
  const bool flat = !(most >= 2);
  if (most < entries) entries = static_cast<int>(most);
  double step = 0;
  if (!flat) {
    step = (b - a) / (entries - 1);
    if (anchor > a && anchor < b) { // one entry more, and all of them moved so that one is at the anchor
      const double below = std::ceil((anchor - a) / step);
      a = anchor - below * step, ++entries;
    }
  }
  table.low = static_cast<float>(a);
  table.scale = flat ? 0.0f : static_cast<float>(1 / step);
  for (int i = 0; i < (flat ? 1 : entries); ++i) {
    const double value = a + step * i;
    const Vec3 c = function.color(value);
    table.entry.push_back({static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]),
                           static_cast<float>(extinction(function.opacity(value), unit_distance))});
  }
  if (!flat && anchor > a && anchor < b) { // without the rounding of a + step * i
    const size_t at = table.index(static_cast<float>(anchor));
    table.entry[at][3] = static_cast<float>(extinction(function.opacity(anchor), unit_distance));
  }
  index_visible(table);
  return table;
}

namespace {

// IEC 61966-2-1.
double linear_of_srgb(double s) {
  constexpr double straight = 0.04045, slope = 12.92; // up to here
  constexpr double offset = 0.055, power = 2.4;       // and beyond
  return s <= straight ? s / slope : std::pow((s + offset) / (1 + offset), power);
}

} // namespace

Vec3 viridis(double x) {
  // The map has ten stops in 8-bit sRGB, with straight lines between them.
  static constexpr uint32_t stops[] = {0x440154, 0x482878, 0x3e4a89, 0x31688e, 0x26828e,
                                       0x1f9e89, 0x35b779, 0x6dcd59, 0xb4de2c, 0xfde725};
  constexpr size_t last = std::size(stops) - 1;
  constexpr uint32_t channel_bits = 8, red_bit = 16, full = 255;
  const double t = std::clamp(x, 0.0, 1.0) * last;
  const size_t n = std::min(static_cast<size_t>(t), last - 1);
  Vec3 linear;
  for (size_t a = 0; a < 3; ++a) {
    const auto channel = [&](uint32_t rgb) {
      return (rgb >> (red_bit - channel_bits * a) & full) / double{full};
    };
    const double f = t - static_cast<double>(n);
    const double s = (1 - f) * channel(stops[n]) + f * channel(stops[n + 1]);
    linear[a] = linear_of_srgb(s);
  }
  return linear;
}

} // namespace bccsplat
