// SPDX-License-Identifier: Apache-2.0
// Suite `rays`: isosurfaces by rays beside sheets and the ray-marcher, first pictures of a slice and later
// ones.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   rays
int run_rays_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
