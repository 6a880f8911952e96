// SPDX-License-Identifier: Apache-2.0
#include "tool/options.h"

#include <cmath>

namespace bcc4 {

std::vector<double> option_numbers(const std::string& option, const std::string& text, size_t count) {
  const auto numbers = parse_numbers(split_commas(text));
  if (!numbers) fail_usage(option, " ", text, ": numbers with commas between them are expected");
  if (count > 0 && numbers->size() != count)
    fail_usage(option, " ", text, ": ", count, " numbers are expected, not ", numbers->size());
  for (const double n : *numbers)
    if (!std::isfinite(n)) fail_usage(option, " ", text, ": numbers must be finite");
  return *numbers;
}

std::vector<std::string> option_names(const std::string& option, const std::string& text) {
  std::vector<std::string> names;
  for (const std::string_view part : split_commas(text)) {
    if (part.empty()) fail_usage(option, " ", text, ": a name is empty");
    names.emplace_back(part);
  }
  return names;
}

uint64_t option_bytes(const std::string& option, const std::string& text) {
  static constexpr std::pair<const char*, double> units[] = {
      {"kib", 0x1p10}, {"mib", 0x1p20}, {"gib", 0x1p30}, {"tib", 0x1p40}, {"kb", 1e3},
      {"mb", 1e6},     {"gb", 1e9},     {"tb", 1e12},    {"k", 0x1p10},   {"m", 0x1p20},
      {"g", 0x1p30},   {"t", 0x1p40},   {"b", 1}};
  std::string number = lower(trim(text));
  double unit = 1;
  for (const auto& [name, factor] : units)
    if (number.ends_with(name)) {
      unit = factor;
      number.resize(number.size() - std::string_view(name).size());
      break;
    }
  const auto value = parse_number<double>(trim(number));
  if (!value || !(*value > 0) || !(*value * unit < 0x1p62))
    fail_usage(option, " ", text, ": a number of bytes is expected, such as 500M or 4G");
  return static_cast<uint64_t>(*value * unit);
}

void require_option(const std::string& value, const char* option, const std::string& example) {
  if (value.empty()) fail_usage(option, " is missing, such as ", example);
}

} // namespace bcc4
