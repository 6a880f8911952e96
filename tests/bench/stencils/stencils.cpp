// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/stencils/stencils.h"

#include <algorithm>
#include <array>

#include "base/error.h"

namespace bccsplat::bench {
namespace {

struct Part {
  const char* option;
  void (*run)(const Report&);
  bool always; // where no option asks for parts
};
constexpr std::array parts{Part{"--fill", stencils_fill, true}, Part{"--picture", stencils_picture, true},
                           Part{"--scenes", stencils_scenes, false}, Part{"--large", stencils_large, false}};

} // namespace

int run_stencils_suite(std::span<const std::string> args, const Report& report) {
  for (const std::string& a : args)
    if (std::none_of(parts.begin(), parts.end(), [&](const Part& p) { return a == p.option; }))
      fail(Code::invalid_argument, "stencils: unknown option ", a);
  for (const Part& p : parts)
    if ((args.empty() && p.always) || std::find(args.begin(), args.end(), p.option) != args.end())
      p.run(report);
  return 0;
}

} // namespace bccsplat::bench
