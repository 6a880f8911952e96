// SPDX-License-Identifier: Apache-2.0
// Adds options to the command line. For those who do so alone: it brings all of CLI11, two seconds to
// compile.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <utility>

#include "tool/options.h"

namespace bcc4 {

template<class Number>
CLI::Option* add_number(CLI::App& app, const std::string& option, std::optional<Number>& target,
                        const std::string& help) {
  return app
      .add_option_function<std::string>(
          option,
          [&target, option](const std::string& text) { target = option_number<Number>(option, text); }, help)
      ->type_name("N");
}

template<class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& option, Value& target, Choices<Value> choices,
                        const std::string& help) {
  std::string names;
  for (const auto& [name, value] : choices) names += (names.empty() ? "" : "|") + name;
  return app
      .add_option_function<std::string>(
          option,
          [&target, option, choices = std::move(choices)](const std::string& text) {
            target = option_choice(option, text, choices);
          },
          help)
      ->type_name(names);
}

void add_threads(CLI::App& app, CommonOptions& options);
void add_max_memory(CLI::App& app, CommonOptions& options);

} // namespace bcc4
