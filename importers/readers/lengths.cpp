// SPDX-License-Identifier: Apache-2.0
#include "readers/lengths.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "readers/text.h"

namespace bcc4 {
namespace {

// Returns the power of ten that a unit is in metres.
std::optional<int> power_of_metre(const std::string& unit) {
  static constexpr std::pair<std::string_view, int> units[] = {{"km", 3},  {"m", 0},        {"dm", -1},
                                                               {"cm", -2}, {"mm", -3},      {"\u00B5m", -6},
                                                               {"nm", -9}, {"\u00C5", -10}, {"pm", -12}};
  for (const auto& [name, power] : units)
    if (name == unit) return power;
  return std::nullopt;
}

} // namespace

std::string length_unit(const std::string& name) {
  if (lower(name).starts_with("degree")) return "degrees"; // to the north, and the like
  for (const char* micron : {"micron", "microns", "um", "\\u00B5m", "\xB5m", "\u00B5m", "\u03BCm"})
    if (name == micron) return "\u00B5m";
  return name.starts_with("pixel") ? "" : name;
}

std::optional<double> length_ratio(const std::string& from, const std::string& to) {
  const auto a = power_of_metre(length_unit(from)), b = power_of_metre(length_unit(to));
  if (a && b) return std::pow(10, *a - *b);
  return from == to ? std::optional(1.0) : std::nullopt;
}

} // namespace bcc4
