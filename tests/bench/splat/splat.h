// SPDX-License-Identifier: Apache-2.0
// Suite `splat`: how fast the splatter's loops run against what the machine can do, and where a frame's time
// goes.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

int run_splat_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
