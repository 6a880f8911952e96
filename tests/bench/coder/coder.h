// SPDX-License-Identifier: Apache-2.0
// Suite `coder`: a trial of a third store on real series, beside today's import and zfp.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   coder --data DIR [--set NAME] [--slab FRAMES] [--edge SAMPLES] [--no-today]: the series of paper_sets.cpp
//   that are in a folder, or one of them; slabs and chunks other than the usual ones; only the trial
// Returns the exit status; throws Error on wrong arguments.
int run_coder_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
