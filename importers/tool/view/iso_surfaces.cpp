// SPDX-License-Identifier: Apache-2.0
#include "tool/view/iso_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "readers/text.h"
#include "tool/options.h"
#include "tool/view/color_space.h"

namespace bcc4 {
namespace {

// A display colour, #rrggbb, in linear light.
std::optional<std::array<double, 3>> parse_color(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  const std::string hex = lower(std::string(text.substr(1)));
  if (hex.find_first_not_of(digits) != std::string::npos) return std::nullopt;
  std::array<double, 3> color;
  for (size_t c = 0; c < 3; ++c)
    color[c] =
        srgb_to_linear(static_cast<double>(16 * digits.find(hex[2 * c]) + digits.find(hex[2 * c + 1])) / 255);
  return color;
}

bccsplat_iso_surface parse_surface(const std::string& all, std::string_view text) {
  const auto parts = split(text, ":");
  const auto wrong = [&] {
    fail_usage("--iso ", all, ": V[:OPACITY[:#RRGGBB]] is expected, several with commas, opacities 0 to 1");
  };
  if (parts.empty() || parts.size() > 3) wrong();
  const auto value = parse_number<double>(trim(parts[0]));
  const auto opacity = parts.size() > 1 ? parse_number<double>(trim(parts[1])) : std::optional(1.0);
  if (!value || !std::isfinite(*value) || !opacity || !(*opacity >= 0 && *opacity <= 1)) wrong();
  bccsplat_iso_surface s{};
  s.value = *value, s.opacity = *opacity;
  if (parts.size() == 3) {
    const auto color = parse_color(trim(parts[2]));
    if (!color) wrong();
    std::copy(color->begin(), color->end(), s.color);
    s.use_color = 1;
  }
  return s;
}

} // namespace

std::vector<bccsplat_iso_surface> parse_surfaces(const std::string& text) {
  std::vector<bccsplat_iso_surface> out;
  for (const auto& part : split(text, ",")) out.push_back(parse_surface(text, trim(part)));
  if (out.size() > BCCSPLAT_MAX_ISO_SURFACES)
    fail_usage("--iso ", text, ": at most ", int{BCCSPLAT_MAX_ISO_SURFACES}, " values");
  return out;
}

} // namespace bcc4
