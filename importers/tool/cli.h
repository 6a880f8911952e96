// SPDX-License-Identifier: Apache-2.0
// The command line: commands and their options. CLI11, which takes three seconds to compile, is known to
// cli.cpp alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tool/options.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace bcc4 {

// An option that was added, for what few of them say of themselves.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  // Sets what help calls its value.
  Option type_name(const std::string& name) const;
  // Sets how many values it takes; -1: any number.
  Option expected(int least, int most) const;

 private:
  CLI::Option* option_;
};

// An option as help and the manual have it.
struct OptionText {
  std::vector<std::string> names; // "-o", "--output"; of what is told by its place "FILE"
  std::string heading;            // of help, that it stands under
  std::string value;              // "FILE", "a|b|c"; "" for a flag
  std::string help;
  bool given = false;
  [[nodiscard]] bool is_argument() const { return !names.front().starts_with('-'); }
};

// One of the tool's commands, or all of them. A handle: the command line owns what it is about.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}
  // The same command; what is added through it stands under this heading of its help.
  [[nodiscard]] Command under(const std::string& heading) const;
  // The same, of a heading that help names alone; "bcc4 help COMMAND topic" prints what stands under it.
  [[nodiscard]] Command under(const std::string& heading, const std::string& topic) const;
  [[nodiscard]] std::string name() const;
  [[nodiscard]] std::string help() const;
  [[nodiscard]] std::vector<Command> commands() const;
  [[nodiscard]] std::vector<OptionText> options() const;
  // Command lines that help and the manual show, one a line.
  [[nodiscard]] std::string examples() const;
  // What --help prints of it; of a topic that alone, of "all" all options. Fails where there is none.
  [[nodiscard]] std::string help_page(const std::string& topic = "") const;
  void set_examples(const std::vector<std::string>& command_lines) const;

  Command add_command(const std::string& name, const std::string& help) const;
  Option add_flag(const std::string& names, bool& target, const std::string& help) const;
  // The value is text, a list of texts, or a number.
  template<class Value>
  Option add_option(const std::string& names, Value& target, const std::string& help) const;
  using Read = std::function<void(const std::string& text)>;
  Option add_text(const std::string& names, const std::string& type, const std::string& help,
                  const Read& read) const;
  // The same of an option that may be given several times, each with one text.
  Option add_texts(const std::string& names, const std::string& type, const std::string& help,
                   const Read& read) const;

 private:
  [[nodiscard]] Option added(CLI::Option* option) const;
  CLI::App* app_;
  std::string heading_; // "": options have no other than that of all
};

class CommandLine {
 public:
  CommandLine(const std::string& name, const std::string& help, const std::string& version);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;
  [[nodiscard]] Command tool() const;
  // Returns the name of the command that was given; "": none. Nothing where help or the version was asked
  // for, which are then printed.
  [[nodiscard]] std::optional<std::string> parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

// The first sentence of a help text, without its full stop, for lists.
[[nodiscard]] std::string first_sentence(const std::string& text);
// Fails with what there is instead of a command of that name.
[[noreturn]] void fail_unknown_command(const Command& tool, const std::string& name);

template<class Number>
void add_number(const Command& command, const std::string& option, std::optional<Number>& target,
                const std::string& help) {
  command.add_text(option, "N", help, [&target, option](const std::string& text) {
    target = option_number<Number>(option, text);
  });
}

template<class Value>
void add_choice(const Command& command, const std::string& option, Value& target, Choices<Value> choices,
                const std::string& help) {
  std::string names;
  for (const auto& [name, value] : choices) names += (names.empty() ? "" : "|") + name;
  command.add_text(option, names, help,
                   [&target, option, choices = std::move(choices)](const std::string& text) {
                     target = option_choice(option, text, choices);
                   });
}

void add_threads(const Command& command, CommonOptions& options);
void add_max_memory(const Command& command, CommonOptions& options);

} // namespace bcc4
