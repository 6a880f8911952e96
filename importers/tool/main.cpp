// SPDX-License-Identifier: Apache-2.0
// bcc4: the command line of bccsplat.
#include <cstdio>
#include <filesystem>
#include <new>

#include "readers/open_series.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/interrupt.h"

namespace bcc4 {
namespace {

std::string quoted(const std::string& word) {
  if (!word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%") ==
          std::string::npos)
    return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

std::string version_number() {
  const int32_t v = bccsplat_version();
  return concat("bcc4 ", v / 10000, ".", v / 100 % 100, ".", v % 100);
}

std::string version_text() {
  std::string text = concat(version_number(), "\n", bccsplat_build_info(), "\nreaders:");
  std::string absent;
  for (const ReaderInfo& r : reader_list()) {
    if (r.present)
      text += concat(" ", r.name, " (", r.detail, ")");
    else
      absent += concat(" ", r.name, " (", r.detail, ")");
  }
  return text + (absent.empty() ? "" : "\nabsent:" + absent);
}

// What the user may have meant by an argument nothing takes.
std::string unknown_argument(const CLI::App& app, const std::string& argument) {
  const auto chosen = app.get_subcommands();
  std::vector<std::string> names;
  if (argument.starts_with("-")) {
    const CLI::App& command = chosen.empty() ? app : *chosen.front();
    for (const CLI::Option* option : command.get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return concat("unknown option ", argument, did_you_mean(argument.substr(0, argument.find('=')), names));
  }
  if (!chosen.empty()) return concat("unexpected argument \"", argument, "\"");
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return concat("unknown command \"", argument, "\"", did_you_mean(argument, names), "; there are ",
                join(names));
}

Exit run(int argc, char** argv) {
  CLI::App app("Time-varying volumes on the D4* lattice: convert, inspect, slice, draw", "bcc4");
  app.set_version_flag("--version", version_text());
  app.set_help_all_flag("--help-all", "Help for all commands");
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::Throw);
  std::string command_line;
  for (int i = 0; i < argc; ++i) command_line += concat(i > 0 ? " " : "", i == 0 ? "bcc4" : quoted(argv[i]));
  const std::vector<std::pair<std::string, Run>> commands{{"import", add_import(app, command_line)},
                                                          {"concat", add_concat(app)},
                                                          {"recode", add_recode(app)},
                                                          {"info", add_info(app)},
                                                          {"verify", add_verify(app)},
                                                          {"export", add_export(app)},
                                                          {"slice", add_slice(app)},
                                                          {"render", add_render(app, command_line)},
                                                          {"completion", add_completion(app)},
                                                          {"manual", add_manual(app, version_number())}};
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) { // --help, --version
    app.exit(e);
    return Exit::ok;
  } catch (const CLI::ExtrasError&) {
    const auto chosen = app.get_subcommands();
    auto extras = app.remaining(true);
    const auto option =
        std::find_if(extras.begin(), extras.end(), [](const std::string& s) { return s.starts_with("-"); });
    fail_usage(unknown_argument(app, option != extras.end() ? *option : extras.front()), "; see bcc4 ",
               chosen.empty() ? "" : chosen.front()->get_name() + " ", "--help");
  } catch (const CLI::ParseError& e) {
    fail_usage(e.what());
  }
  const auto chosen = app.get_subcommands();
  if (chosen.empty()) {
    std::fprintf(stderr, "%s", app.help().c_str());
    return Exit::usage;
  }
  for (const auto& [name, command] : commands)
    if (name == chosen.front()->get_name()) return command();
  return Exit::usage;
}

int report(Exit exit, const char* text) {
  std::fflush(stdout);
  std::fprintf(stderr, "bcc4: %s\n", text);
  return static_cast<int>(exit);
}

} // namespace
} // namespace bcc4

int main(int argc, char** argv) {
  using bcc4::Exit;
  bcc4::catch_interrupts();
  try {
    const Exit exit = bcc4::run(argc, argv);
    if (std::fflush(stdout) != 0)
      return bcc4::report(Exit::no_resources, "standard output cannot be written");
    return static_cast<int>(exit);
  } catch (const bcc4::Error& e) {
    return bcc4::report(e.exit(), e.what());
  } catch (const std::bad_alloc&) {
    return bcc4::report(Exit::no_resources, "out of memory; lower --max-mem or take fewer frames");
  } catch (const std::exception& e) {
    return bcc4::report(Exit::bad_input, e.what());
  }
}
