// SPDX-License-Identifier: Apache-2.0
// Suite `scale`: what grows with points, frames, pixels and threads, and what does not.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   scale [--large DIR]   DIR: a folder with some GB of room for 256^3 x 256 samples, 4 GiB, written, opened
//   and drawn
//   scale --blocks N,FRAMES,LEVELS,PIECES FILE   nothing but a series of N^3 samples a frame in blocks of
//   space, PIECES along z and half as many along y (scale_blocks.h)
// Through the C API alone, as a host sees it. Returns the exit status; throws Error on wrong arguments.
int run_scale_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
