// bccsplat_bench SUITE [options]: benchmarks and measurements, by name.
#include <cstdio>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/bench/fit.h"
#include "tests/bench/kernels.h"

namespace {

struct Suite {
  const char* name;
  int (*run)(std::span<const std::string> args, std::ostream& out);
};

constexpr Suite suites[] = {{"kernels", bccsplat::bench::run_kernels_suite},
                            {"fit", bccsplat::bench::run_fit_suite}};

} // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> args(argv + 1, argv + argc);
  try {
    for (const Suite& suite : suites)
      if (!args.empty() && args[0] == suite.name) return suite.run(std::span(args).subspan(1), std::cout);
  } catch (const bccsplat::Error& e) {
    std::fprintf(stderr, "bccsplat_bench: %s\n", e.what());
    return 2;
  }
  std::fprintf(stderr, "usage: bccsplat_bench SUITE [options]\nsuites:");
  for (const Suite& suite : suites) std::fprintf(stderr, " %s", suite.name);
  std::fprintf(stderr, "\n");
  return 2;
}
