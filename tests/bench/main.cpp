// SPDX-License-Identifier: Apache-2.0
// bccsplat_bench SUITE [--json] [--quick] [--plots DIR] [the suite's options]: benchmarks and measurements,
// by name.
#include <cstdio>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/bench/cancel/cancel.h"
#include "tests/bench/coder/coder.h"
#include "tests/bench/evaluate/evaluate.h"
#include "tests/bench/fit/fit.h"
#if BCCSPLAT_WITH_GPU
#include "tests/bench/gpu/gpu.h"
#endif
#include "tests/bench/host/host_frames.h"
#include "tests/bench/import/import.h"
#include "tests/bench/kernels/kernels.h"
#include "tests/bench/moments/moments.h"
#include "tests/bench/motion/motion.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/pictures/pictures.h"
#include "tests/bench/rays/rays.h"
#include "tests/bench/render/render.h"
#include "tests/bench/report.h"
#include "tests/bench/scale/scale.h"
#include "tests/bench/skip/skip.h"
#include "tests/bench/slice/slice.h"
#include "tests/bench/splat/splat.h"
#include "tests/bench/storage/storage.h"
#include "tests/bench/trail/trail.h"

namespace {

using bccsplat::bench::Report;

struct Suite {
  const char* name;
  int (*run)(std::span<const std::string> args, const Report& report);
};

constexpr Suite suites[] = {
    {"kernels", bccsplat::bench::run_kernels_suite}, {"evaluate", bccsplat::bench::run_evaluate_suite},
    {"fit", bccsplat::bench::run_fit_suite},         {"trail", bccsplat::bench::run_trail_suite},
    {"storage", bccsplat::bench::run_storage_suite}, {"render", bccsplat::bench::run_render_suite},
    {"skip", bccsplat::bench::run_skip_suite},       {"scale", bccsplat::bench::run_scale_suite},
    {"splat", bccsplat::bench::run_splat_suite},     {"slice", bccsplat::bench::run_slice_suite},
    {"paper", bccsplat::bench::run_paper_suite},     {"import", bccsplat::bench::run_import_suite},
    {"moments", bccsplat::bench::run_moments_suite}, {"pictures", bccsplat::bench::run_pictures_suite},
    {"cancel", bccsplat::bench::run_cancel_suite},   {"rays", bccsplat::bench::run_rays_suite},
#if BCCSPLAT_WITH_GPU
    {"gpu", bccsplat::bench::run_gpu_suite},
#endif
    {"scene", bccsplat::bench::run_scene_suite},     {"coder", bccsplat::bench::run_coder_suite},
    {"motion", bccsplat::bench::run_motion_suite}};

int usage() {
  std::fprintf(stderr, "usage: bccsplat_bench SUITE [--json] [--quick] [--plots DIR] [options]\nsuites:");
  for (const Suite& suite : suites) std::fprintf(stderr, " %s", suite.name);
  std::fprintf(stderr, "\n");
  return 2;
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2) return usage();
  const std::string name = argv[1];
  Report report{.out = std::cout, .suite = name, .plots = {}};
  std::vector<std::string> rest;
  for (int i = 2; i < argc; ++i) {
    const std::string arg = argv[i];
    if (arg == "--json")
      report.json = true;
    else if (arg == "--quick")
      report.quick = true;
    else if (arg == "--plots" && i + 1 < argc)
      report.plots = argv[++i];
    else
      rest.push_back(arg);
  }
  try {
    for (const Suite& suite : suites) {
      if (name != suite.name) continue;
      if (rest.empty() && !report.json) std::cout << bccsplat::bench::machine_facts() << "\n";
      return suite.run(rest, report);
    }
  } catch (const bccsplat::Error& e) {
    std::fprintf(stderr, "bccsplat_bench: %s\n", e.what());
    return 2;
  }
  return usage();
}
