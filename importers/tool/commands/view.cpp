// SPDX-License-Identifier: Apache-2.0
// bcc4 view: the viewer of examples/web and a file, served to the browser on this machine.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/interrupt.h"
#include "tool/serve/http_server.h"
#include "tool/system.h"

namespace bcc4 {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  std::string file, page;
  int port = 0;
};

constexpr int last_port = 65535;
constexpr const char* served_as = "/file.bcc4";

// The folder of the page: as given, installed with the tool, or built beside it.
fs::path find_page(const std::string& given) {
  const fs::path tool = program_folder();
  for (const fs::path& folder :
       given.empty() ? std::vector<fs::path>{tool / "../share/bccsplat/web", tool / "../../build-web/site"}
                     : std::vector<fs::path>{given})
    if (fs::exists(folder / "core.wasm")) return fs::canonical(folder);
  if (!given.empty())
    fail_input(given, ": no viewer is there (no core.wasm); examples/web/build.sh makes one");
  fail_input(
      "no viewer is installed with this tool; examples/web/build.sh FOLDER makes one, and --page FOLDER "
      "shows it");
}

// Files of the page's own folder by name, and the file that is looked at.
FindFile files_of(const fs::path& page, const fs::path& file) {
  return [page, file](const std::string& path) -> std::optional<std::string> {
    if (path == served_as) return file.string();
    if (!path.starts_with('/')) return std::nullopt;
    const std::string name = path == "/" ? "index.html" : path.substr(1);
    if (name.find('/') != std::string::npos || name.starts_with(".")) return std::nullopt;
    return (page / name).string();
  };
}

void print_link(uint16_t port) {
  catch_interrupts();
  std::printf("http://127.0.0.1:%u/?url=%s\n", port, served_as + 1);
  std::fflush(stdout);
  std::fprintf(stderr, "Open this link in a browser; Ctrl-C ends.\n");
}

} // namespace

Run add_view(const Command& tool) {
  auto a = std::make_shared<ViewArguments>();
  const Command view = tool.add_command("view", "Look at a .bcc4 file in a browser on this machine.");
  view.set_examples({"bcc4 view smoke.bcc4"});
  view.add_option("FILE", a->file, "A .bcc4 file");
  view.add_option("--page", a->page,
                  "Folder of the viewer, as examples/web/build.sh makes it (default: installed)");
  view.add_option("--port", a->port, "Port of 127.0.0.1 (default: any that is free)");
  return [a] {
    require_option(a->file, "FILE", "bcc4 view smoke.bcc4");
    if (a->port < 0 || a->port > last_port) fail_usage("--port ", a->port, ": 0 to ", last_port);
    (void)open_volume(create_device(1, 0), a->file, ""); // says what is wrong with it before a browser does
    serve_files({static_cast<uint16_t>(a->port), files_of(find_page(a->page), fs::canonical(a->file)),
                 print_link, interrupted});
    return Exit::ok;
  };
}

} // namespace bcc4
