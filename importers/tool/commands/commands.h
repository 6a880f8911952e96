// SPDX-License-Identifier: Apache-2.0
// The subcommands. Each adds itself to the command line and returns what to run once it has been parsed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "readers/error.h"

namespace CLI {
class App;
}

namespace bcc4 {

using Run = std::function<Exit()>;

// `command_line` is what the user typed, quoted for repeating.
[[nodiscard]] Run add_import(CLI::App& app, std::string command_line);
[[nodiscard]] Run add_concat(CLI::App& app);
[[nodiscard]] Run add_recode(CLI::App& app);
[[nodiscard]] Run add_info(CLI::App& app);
[[nodiscard]] Run add_verify(CLI::App& app);
[[nodiscard]] Run add_slice(CLI::App& app);
[[nodiscard]] Run add_export(CLI::App& app);
[[nodiscard]] Run add_render(CLI::App& app, std::string command_line);
[[nodiscard]] Run add_manual(CLI::App& app, std::string version);
[[nodiscard]] Run add_completion(CLI::App& app);

} // namespace bcc4
