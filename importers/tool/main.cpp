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
#include "tool/system.h"

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

Exit run(int argc, char** argv) {
  CommandLine line("bcc4", "Store a 3D movie in half the samples, read any moment, draw it", version_text());
  const Command tool = line.tool();
  tool.set_examples({"bcc4 import smoke.*.raw --dims 64,64,64 --dtype f32 -o smoke.bcc4",
                     "bcc4 render smoke.bcc4 --time 1.5 -o smoke.png", "bcc4 help render"});
  std::string command_line;
  for (int i = 0; i < argc; ++i) command_line += concat(i > 0 ? " " : "", i == 0 ? "bcc4" : quoted(argv[i]));
  const std::vector<std::pair<std::string, Run>> commands{{"import", add_import(tool, command_line)},
                                                          {"concat", add_concat(tool)},
                                                          {"info", add_info(tool)},
                                                          {"verify", add_verify(tool)},
                                                          {"compare", add_compare(tool)},
                                                          {"probe", add_probe(tool)},
                                                          {"export", add_export(tool)},
                                                          {"slice", add_slice(tool)},
                                                          {"render", add_render(tool, command_line)},
                                                          {"help", add_help(tool)},
                                                          {"view", add_view(tool)},
                                                          {"completion", add_completion(tool)},
                                                          {"manual", add_manual(tool, version_number())}};
  const std::optional<std::string> chosen = line.parse(argc, argv);
  if (!chosen) return Exit::ok;
  for (const auto& [name, command] : commands)
    if (name == *chosen) return command();
  std::fprintf(stderr, "%s", tool.help_page().c_str());
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
    std::vector<std::string> words = bcc4::command_line_words(argc, argv);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const Exit exit = bcc4::run(static_cast<int>(words.size()), pointers.data());
    if (std::fflush(stdout) != 0)
      return bcc4::report(Exit::no_resources, "standard output cannot be written");
    return static_cast<int>(exit);
  } catch (const bcc4::Error& e) {
    return bcc4::report(bcc4::exit_of(e.code()), (e.message() + bcc4::advice_on(e.code())).c_str());
  } catch (const std::bad_alloc&) {
    return bcc4::report(Exit::no_resources, "out of memory; lower --max-mem or take fewer frames");
  } catch (const std::exception& e) {
    return bcc4::report(Exit::bad_input, e.what());
  }
}
