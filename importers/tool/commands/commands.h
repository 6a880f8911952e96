// SPDX-License-Identifier: Apache-2.0
// The subcommands. Each adds itself to the command line and returns what to run once it has been parsed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "readers/error.h"

namespace bcc4 {

class Command; // tool/cli.h

using Run = std::function<Exit()>;

// `command_line` is what the user typed, quoted for repeating.
[[nodiscard]] Run add_import(Command tool, std::string command_line);
[[nodiscard]] Run add_concat(Command tool);
[[nodiscard]] Run add_recode(Command tool);
[[nodiscard]] Run add_info(Command tool);
[[nodiscard]] Run add_verify(Command tool);
[[nodiscard]] Run add_compare(Command tool);
[[nodiscard]] Run add_probe(Command tool);
[[nodiscard]] Run add_slice(Command tool);
[[nodiscard]] Run add_export(Command tool);
[[nodiscard]] Run add_render(Command tool, std::string command_line);
[[nodiscard]] Run add_help(Command tool);
[[nodiscard]] Run add_view(Command tool);
[[nodiscard]] Run add_manual(Command tool, std::string version);
[[nodiscard]] Run add_completion(Command tool);

} // namespace bcc4
