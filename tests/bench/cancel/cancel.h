// SPDX-License-Identifier: Apache-2.0
// Suite `cancel`: how long calls go on after their token was cancelled.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   cancel [--size N] [--trials N] [--only WORD]   N^3 x 8 samples; calls whose names hold WORD
// Every call is made once to its end and then cancelled at random moments. Through the C API alone, as a host
// sees it. Returns the exit status; throws Error on wrong arguments.
int run_cancel_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
