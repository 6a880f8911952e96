// SPDX-License-Identifier: Apache-2.0
// The subcommands. Each adds itself to the command line and returns what to run once it has been parsed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tool/exit.h"

namespace bcc4 {

class Command; // tool/cli.h

using Run = std::function<Exit()>;

// `command_line` is what the user typed, quoted for repeating.
[[nodiscard]] Run add_import(const Command& tool, std::string command_line);
[[nodiscard]] Run add_concat(const Command& tool);
[[nodiscard]] Run add_info(const Command& tool);
[[nodiscard]] Run add_verify(const Command& tool);
[[nodiscard]] Run add_compare(const Command& tool);
[[nodiscard]] Run add_probe(const Command& tool);
[[nodiscard]] Run add_slice(const Command& tool);
[[nodiscard]] Run add_export(const Command& tool);
[[nodiscard]] Run add_render(const Command& tool, std::string command_line);
[[nodiscard]] Run add_help(const Command& tool);
[[nodiscard]] Run add_view(const Command& tool);
[[nodiscard]] Run add_manual(const Command& tool, std::string version);
[[nodiscard]] Run add_completion(const Command& tool);

} // namespace bcc4
