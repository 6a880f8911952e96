// SPDX-License-Identifier: Apache-2.0
// Suite `coder`: real series stored as wavelets, beside the tool's other ways and zfp.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   coder --data DIR [--set NAME] [--wavelets-only]: the series of paper_sets.cpp that are in a folder, or
//   one of them
// Returns the exit status; throws Error on wrong arguments.
int run_coder_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
