// SPDX-License-Identifier: Apache-2.0
// What the low-pass before resampling costs and what it is worth.
#pragma once

#include "tests/bench/report.h"

namespace bccsplat::bench {

void report_lowpass(const Report& report);

} // namespace bccsplat::bench
