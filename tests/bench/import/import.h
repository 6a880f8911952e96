// SPDX-License-Identifier: Apache-2.0
// Suite `import`: what it costs to import a series, beside reading it and no more.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

int run_import_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
