// SPDX-License-Identifier: Apache-2.0
// Suite `motion`: moments that follow the motion between stored frames, beside those that do not.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   motion [--data DIR] [--set NAME]: blobs and smoke, and the real series of paper_sets.cpp that are in a
//   folder; or those alone whose name begins so
// Returns the exit status; throws Error on wrong arguments.
int run_motion_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
