// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// What an import, a random moment and playing cost: processor time, memory, bytes read, layers decoded;
// beside raw frames in memory and gzip.
// --edge N: voxels along each axis, 256 by default; --frames N: 16. --dense, --sparse: only these series.
// --count N: random moments. --cache MIB: in place of a volume's default. --levels N: what so many coarser
// levels cost, and give; --pictures: nothing but pictures of them,
// --contents: of series that differ in what fills them; --slices: nothing but slices of files by the tool.
// --cuts: x slices and oblique ones, too.
int run_moments_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
