// SPDX-License-Identifier: Apache-2.0
// Converts display colours to CIELAB (D65), HSV and Moreland's Msh and back, and blends in them.
#include "tool/view/color_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bcc4 {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Color kWhite{0.9505, 1.0, 1.089}; // D65, XYZ

Color to_lab(const Color& display) {
  const double r = srgb_to_linear(display[0]), g = srgb_to_linear(display[1]), b = srgb_to_linear(display[2]);
  const Color xyz{0.4124 * r + 0.3576 * g + 0.1805 * b, 0.2126 * r + 0.7152 * g + 0.0722 * b,
                  0.0193 * r + 0.1192 * g + 0.9505 * b};
  const auto f = [&](size_t i) {
    const double t = xyz[i] / kWhite[i];
    return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  };
  return {116 * f(1) - 16, 500 * (f(0) - f(1)), 200 * (f(1) - f(2))};
}

Color from_lab(const Color& lab) {
  const double fy = (lab[0] + 16) / 116;
  const auto inverse = [](double f) {
    return f * f * f > 216.0 / 24389 ? f * f * f : (116 * f - 16) * 27 / 24389;
  };
  const double x = kWhite[0] * inverse(fy + lab[1] / 500), y = kWhite[1] * inverse(fy),
               z = kWhite[2] * inverse(fy - lab[2] / 200);
  const Color linear{3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
                     0.0557 * x - 0.2040 * y + 1.0570 * z};
  Color out;
  for (size_t i = 0; i < 3; ++i) out[i] = linear_to_srgb(std::clamp(linear[i], 0.0, 1.0));
  return out;
}

Color mix(const Color& a, const Color& b, double t) {
  return {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]};
}

Color to_hsv(const Color& c) {
  const double high = std::max({c[0], c[1], c[2]}), range = high - std::min({c[0], c[1], c[2]});
  double hue = 0;
  if (range > 0) {
    if (high == c[0])
      hue = (c[1] - c[2]) / range;
    else if (high == c[1])
      hue = 2 + (c[2] - c[0]) / range;
    else
      hue = 4 + (c[0] - c[1]) / range;
    hue /= 6;
    if (hue < 0) hue += 1;
  }
  return {hue, high > 0 ? range / high : 0, high};
}

Color from_hsv(const Color& hsv) {
  Color out;
  for (size_t i = 0; i < 3; ++i) {
    const double k = std::fmod(5 - 2 * static_cast<double>(i) + 6 * hsv[0], 6.0);
    out[i] = hsv[2] * (1 - hsv[1] * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  }
  return out;
}

// Magnitude, saturation, hue of a Lab colour (Moreland, section 4).
Color to_msh(const Color& lab) {
  const double m = std::hypot(lab[0], lab[1], lab[2]);
  const double s = m > 1e-3 ? std::acos(std::clamp(lab[0] / m, -1.0, 1.0)) : 0;
  return {m, s, s > 1e-3 ? std::atan2(lab[2], lab[1]) : 0};
}

Color from_msh(const Color& msh) {
  return {msh[0] * std::cos(msh[1]), msh[0] * std::sin(msh[1]) * std::cos(msh[2]),
          msh[0] * std::sin(msh[1]) * std::sin(msh[2])};
}

// The hue to use for an unsaturated colour next to a saturated one.
double spun_hue(const Color& msh, double unsaturated_m) {
  if (msh[0] >= unsaturated_m - 0.1) return msh[2];
  const double spin =
      msh[1] * std::sqrt(unsaturated_m * unsaturated_m - msh[0] * msh[0]) / (msh[0] * std::sin(msh[1]));
  return msh[2] > -0.3 * kPi ? msh[2] + spin : msh[2] - spin;
}

Color blend_diverging(const Color& a, const Color& b, double t) {
  Color from = to_msh(to_lab(a)), to = to_msh(to_lab(b));
  double turn = std::abs(from[2] - to[2]);
  if (turn > kPi) turn = 2 * kPi - turn;
  if (from[1] > 0.05 && to[1] > 0.05 && turn > kPi / 3) { // through white
    const double m = std::max({from[0], to[0], 88.0});
    if (t < 0.5) {
      to = {m, 0, 0};
      t *= 2;
    } else {
      from = {m, 0, 0};
      t = 2 * t - 1;
    }
  }
  if (from[1] < 0.05 && to[1] > 0.05)
    from[2] = spun_hue(to, from[0]);
  else if (to[1] < 0.05 && from[1] > 0.05)
    to[2] = spun_hue(from, to[0]);
  return from_lab(from_msh(mix(from, to, t)));
}

} // namespace

double srgb_to_linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double linear_to_srgb(double v) { return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1 / 2.4) - 0.055; }

Color blend(const Color& a, const Color& b, double t, BlendSpace space) {
  switch (space) {
  case BlendSpace::lab:
    return from_lab(mix(to_lab(a), to_lab(b), t));
  case BlendSpace::diverging:
    return blend_diverging(a, b, t);
  case BlendSpace::hsv: {
    Color from = to_hsv(a), to = to_hsv(b);
    if (from[0] - to[0] > 0.5)
      to[0] += 1; // the short way round
    else if (to[0] - from[0] > 0.5)
      from[0] += 1;
    Color hsv = mix(from, to, t);
    hsv[0] = std::fmod(hsv[0], 1.0);
    return from_hsv(hsv);
  }
  case BlendSpace::rgb:
    break;
  }
  return mix(a, b, t);
}

} // namespace bcc4
