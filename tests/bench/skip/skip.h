// SPDX-License-Identifier: Apache-2.0
// Suite `skip`: what each way of skipping saves, and that it changes no pixel.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

int run_skip_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
