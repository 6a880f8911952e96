// SPDX-License-Identifier: Apache-2.0
// The command line by CLI11, which no other file includes.
#include "tool/cli.h"

#include <CLI/CLI.hpp>

#include <algorithm>

namespace bcc4 {

Option Option::type_name(const std::string& name) const { return Option(option_->type_name(name)); }
Option Option::group(const std::string& heading) const { return Option(option_->group(heading)); }
Option Option::expected(int least, int most) const { return Option(option_->expected(least, most)); }

std::string Command::name() const { return app_->get_name(); }
std::string Command::help() const { return app_->get_description(); }

std::vector<Command> Command::commands() const {
  std::vector<Command> commands;
  for (CLI::App* command : app_->get_subcommands([](const CLI::App*) { return true; }))
    commands.emplace_back(command);
  return commands;
}

std::vector<OptionText> Command::options() const {
  std::vector<OptionText> texts;
  for (const CLI::Option* option : std::as_const(*app_).get_options()) {
    OptionText& text = texts.emplace_back();
    for (const std::string& name : option->get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) text.names.push_back("--" + name);
    if (text.names.empty()) text.names = {option->get_name(true)};
    if (option->get_type_size() != 0) text.value = option->get_type_name();
    text.help = option->get_description();
    text.given = option->count() > 0;
  }
  return texts;
}

Command Command::add_command(const std::string& name, const std::string& help) const {
  return Command(app_->add_subcommand(name, help));
}

Option Command::add_flag(const std::string& names, bool& target, const std::string& help) const {
  return Option(app_->add_flag(names, target, help));
}

template<class Value>
Option Command::add_option(const std::string& names, Value& target, const std::string& help) const {
  return Option(app_->add_option(names, target, help));
}
template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, int32_t&, const std::string&) const;
template Option Command::add_option(const std::string&, uint32_t&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<uint32_t>&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;

Option Command::add_text(const std::string& names, const std::string& type, const std::string& help,
                         const Read& read) const {
  return Option(app_->add_option_function<std::string>(names, read, help)->type_name(type));
}

Option Command::add_texts(const std::string& names, const std::string& type, const std::string& help,
                          const Read& read) const {
  const auto read_all = [read](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) read(text);
  };
  return Option(app_->add_option_function<std::vector<std::string>>(names, read_all, help)
                    ->type_name(type)
                    ->allow_extra_args(false));
}

namespace {

// Returns what the user may have meant by an argument nothing takes.
std::string unknown_argument(const Command& tool, const Command* chosen, const std::string& argument) {
  std::vector<std::string> names;
  if (argument.starts_with("-")) {
    for (const OptionText& option : (chosen ? *chosen : tool).options())
      std::copy_if(option.names.begin(), option.names.end(), std::back_inserter(names),
                   [](const std::string& name) { return name.starts_with("--"); });
    return concat("unknown option ", argument, did_you_mean(argument.substr(0, argument.find('=')), names));
  }
  if (chosen) return concat("unexpected argument \"", argument, "\"");
  for (const Command& command : tool.commands()) names.push_back(command.name());
  return concat("unknown command \"", argument, "\"", did_you_mean(argument, names), "; there are ",
                join(names));
}

} // namespace

CommandLine::CommandLine(const std::string& name, const std::string& help, const std::string& version)
    : app_(std::make_unique<CLI::App>(help, name)) {
  app_->set_version_flag("--version", version);
  app_->set_help_all_flag("--help-all", "Help for all commands");
  app_->option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::Throw);
}

CommandLine::~CommandLine() = default;

Command CommandLine::tool() const { return Command(app_.get()); }
std::string CommandLine::help_text() const { return app_->help(); }

std::optional<std::string> CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& e) {
    app_->exit(e);
    return std::nullopt;
  } catch (const CLI::ExtrasError&) {
    const std::vector<CLI::App*> chosen = app_->get_subcommands();
    const std::vector<std::string> extras = app_->remaining(true);
    const auto option =
        std::find_if(extras.begin(), extras.end(), [](const std::string& s) { return s.starts_with("-"); });
    const std::optional<Command> command =
        chosen.empty() ? std::nullopt : std::optional(Command(chosen.front()));
    fail_usage(unknown_argument(tool(), command ? &*command : nullptr,
                                option != extras.end() ? *option : extras.front()),
               "; see bcc4 ", command ? command->name() + " " : "", "--help");
  } catch (const CLI::ParseError& e) {
    fail_usage(e.what());
  }
  const std::vector<CLI::App*> chosen = app_->get_subcommands();
  return chosen.empty() ? "" : chosen.front()->get_name();
}

void add_threads(Command command, CommonOptions& options) {
  command.add_text("--threads", "N", "Threads to use (default: as many as the machine has)",
                   [&options](const std::string& text) {
                     options.threads = option_number<int>("--threads", text);
                     if (options.threads < 1) fail_usage("--threads ", text, ": at least 1");
                   });
}

void add_max_memory(Command command, CommonOptions& options) {
  command.add_text(
      "--max-mem", "BYTES", "Memory for data, such as 500M or 4G (default: no limit)",
      [&options](const std::string& text) { options.max_memory = option_bytes("--max-mem", text); });
}

} // namespace bcc4
