// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Size, reading time and random access of .bcc4 files. --sizes, --levels, --access, --rate: only these
// tables.
int run_storage_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
