// SPDX-License-Identifier: Apache-2.0
// What `bcc4 import` chooses for real series and for generated ones that are no balls of frequencies, beside
// the other ways to keep as many samples, and beside zfp.
#pragma once

#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Runs the tool on every 4D set of a folder (those that are there) and on generated ones. Says loudly what it
// cannot compare with where zfp or the tool are not built in.
void report_real(const std::string& folder, const Report& report);

} // namespace bccsplat::bench
