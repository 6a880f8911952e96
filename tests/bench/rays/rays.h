// SPDX-License-Identifier: Apache-2.0
// Suite `rays`: a prototype of isosurfaces by rays with a proven bound, beside sheets and the ray-marcher.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   rays
int run_rays_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
