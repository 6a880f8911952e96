// SPDX-License-Identifier: Apache-2.0
// Suite `scene`: what a host's frames cost, with its depths, clips and several volumes in them.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   scene [--edges N,N,...] [--frames N]   series of N^3 voxels (128,256), N pictures a row (30)
// Pictures of 640 x 360 while camera and time move on, through the C API alone, two threads. Returns the exit
// status; throws Error on wrong arguments.
int run_scene_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
