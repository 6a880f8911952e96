// SPDX-License-Identifier: Apache-2.0
// The values of options: numbers without the locale, words with the nearest name, positions of mistakes. Who
// adds options to the command line includes tool/cli.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "readers/error.h"

namespace bcc4 {

class Command; // cli.h

// A number, or an error that names the option and what it got.
template<class Number> [[nodiscard]] Number option_number(const std::string& option, std::string_view text) {
  const auto value = parse_number<Number>(trim(text));
  if (!value) fail_usage(option, " ", text, ": a number is expected");
  return *value;
}
// "1,2.5,3" as exactly `count` numbers (0: any count).
[[nodiscard]] std::vector<double> option_numbers(const std::string& option, const std::string& text,
                                                 size_t count);
// "a,b,c", none empty.
[[nodiscard]] std::vector<std::string> option_names(const std::string& option, const std::string& text);
// "512M", "2G", "1500000": bytes.
[[nodiscard]] uint64_t option_bytes(const std::string& option, const std::string& text);

template<class Value> using Choices = std::vector<std::pair<std::string, Value>>;
template<class Value>
[[nodiscard]] Value option_choice(const std::string& option, const std::string& text,
                                  const Choices<Value>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) {
    if (name == text) return value;
    names.push_back(name);
  }
  fail_usage(option, " ", text, ": must be ", join(names, " or "), did_you_mean(text, names));
}
// Options nearly every command has.
struct CommonOptions {
  int threads = 0;
  uint64_t max_memory = 0; // bytes; 0: no limit
  bool json = false;
  bool quiet = false;
  [[nodiscard]] bool prints_text() const { return !json && !quiet; }
};
// Throws unless the option was given.
void require_option(const std::string& value, const char* option, const std::string& example);

} // namespace bcc4
