// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/ticks.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr int most_digits = 12, digits_of_one = 5;
constexpr double largest_written_out = 1e6;

std::string text_of(double value, std::chars_format format, int digits) {
  char buffer[400];
  std::string text(buffer, std::to_chars(buffer, buffer + sizeof buffer, value, format, digits).ptr);
  if (const size_t e = text.find('e'); e != std::string::npos) { // 1e5 and 1e-5, not 1e+05 and 1e-05
    if (text[e + 1] == '+') text.erase(e + 1, 1);
    const size_t digit = text[e + 1] == '-' ? e + 2 : e + 1;
    if (text[digit] == '0') text.erase(digit, 1);
  }
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

// The smallest difference of neighbours that differ; 0 where none do.
double nearest_difference(const std::vector<double>& values) {
  double nearest = 0;
  for (size_t i = 1; i < values.size(); ++i) {
    const double difference = std::fabs(values[i] - values[i - 1]);
    if (difference > 0 && (nearest == 0 || difference < nearest)) nearest = difference;
  }
  return nearest;
}

// Digits behind the point that keep every value, in `unit`; of values that go on and on, one more than tells
// them apart.
int digits_of(const std::vector<double>& values, double nearest, double unit) {
  const double apart = nearest / unit;
  const int most = std::clamp(static_cast<int>(std::ceil(-std::log10(apart))) + 1, 0, most_digits);
  int digits = 0;
  for (const double v : values) {
    const auto off = [&](int d) {
      const double power = std::pow(10, d), scaled = v / unit * power;
      return std::fabs(scaled - std::round(scaled)) > 1e-3 * apart * power;
    };
    while (digits < most && off(digits)) ++digits;
  }
  return digits;
}

} // namespace

double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0})
    if (step * power <= value * (1 + 1e-9)) return step * power;
  return power;
}

std::vector<double> round_ticks(double low, double high, size_t most) {
  if (!(high > low) || !std::isfinite(high - low)) return {low};
  double step = round_below((high - low) / static_cast<double>(most));
  for (;;) {
    const double first = std::ceil(low / step - 1e-6), last = std::floor(high / step + 1e-6);
    if (last - first + 1 <= static_cast<double>(most)) {
      std::vector<double> ticks;
      for (double i = first; i <= last; ++i) ticks.push_back(i * step);
      return ticks;
    }
    step = round_below(2.5 * step); // 1, 2, 5, 10
  }
}

std::vector<std::string> tick_texts(const std::vector<double>& values) {
  const double nearest = nearest_difference(values);
  if (nearest == 0)
    return std::vector<std::string>(values.size(),
                                    values.empty() ? "" : short_number(values.front(), digits_of_one));
  double largest = 0, least = 0; // but for 0
  for (const double v : values) {
    largest = std::max(largest, std::fabs(v));
    if (v != 0 && (least == 0 || std::fabs(v) < least)) least = std::fabs(v);
  }
  const bool exponents = largest >= largest_written_out || (largest > 0 && largest < 1e-3);
  std::vector<std::string> texts;
  if (exponents) {
    const double unit = std::pow(10, std::floor(std::log10(largest)));
    const int digits = digits_of(values, nearest, unit);
    for (const double v : values)
      texts.push_back(v == 0 ? std::string("0")
                             : text_of(v, std::chars_format::scientific,
                                       std::clamp(digits + static_cast<int>(std::floor(
                                                               std::log10(std::fabs(v)) - std::log10(unit))),
                                                  0, most_digits)));
  } else {
    const int digits = digits_of(values, nearest, 1);
    for (const double v : values) texts.push_back(text_of(v, std::chars_format::fixed, digits));
  }
  return texts;
}

} // namespace bcc4
