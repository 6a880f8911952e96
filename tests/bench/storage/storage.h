#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Size, reading time and random access of .bcc4 files, coefficients as integer codes, and what a random
// moment costs.
// --sizes, --levels, --access, --rate, --coefficients, --moments: only these tables. --data DIR: the folder
// of the real series that --coefficients reads. --edge N: voxels along each axis of --moments, 256 by
// default.
int run_storage_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
