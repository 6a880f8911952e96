// SPDX-License-Identifier: Apache-2.0
// What the lattice in time is worth on real series: every second frame is left out and asked for.
#pragma once

#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// The 4D sets of a folder: frames that were left out, out of those that were not, by the library and by
// interpolation from voxel to voxel.
void report_held_out(const std::string& folder, const Report& report);

} // namespace bccsplat::bench
