// SPDX-License-Identifier: Apache-2.0
// Suite `trail`: what a picture with a motion trail costs, as a ratio to the picture without.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   trail [--fine] [--steps]: against finer trails alone; more stills or closer sheets alone. Returns the
//   exit status; throws Error on wrong arguments.
int run_trail_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
