// SPDX-License-Identifier: Apache-2.0
// How much less accurate a series is near its ends than inside.
#pragma once

#include "tests/bench/fit/fit_source.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// Known fields, at points between samples and frames.
void report_ends(const Report& report);
// A series as it is: its first and last frames.
void report_ends(const FitSource& source, const Report& report);
// The short series of a folder.
void report_ends(const std::string& folder, const Report& report);

} // namespace bccsplat::bench
