// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/pictures/pictures.h"

#include <algorithm>
#include <array>
#include <set>

#include "base/error.h"

namespace bccsplat::bench {
namespace {

struct Part {
  const char* option;
  void (*run)(const std::string& folder, const Report&);
};
constexpr std::array parts{Part{"--plateaus", pictures_plateaus}, Part{"--light", pictures_light},
                           Part{"--background", pictures_background}};

} // namespace

int run_pictures_suite(std::span<const std::string> args, const Report& report) {
  std::set<std::string> asked;
  std::string folder;
  for (size_t i = 0; i < args.size(); ++i) {
    if (args[i] == "--data" && i + 1 < args.size())
      folder = args[++i];
    else if (std::any_of(parts.begin(), parts.end(), [&](const Part& p) { return args[i] == p.option; }))
      asked.insert(args[i]);
    else
      fail(Code::invalid_argument, "pictures: unknown option ", args[i]);
  }
  for (const Part& p : parts)
    if (asked.empty() || asked.contains(p.option)) p.run(folder, report);
  return 0;
}

} // namespace bccsplat::bench
