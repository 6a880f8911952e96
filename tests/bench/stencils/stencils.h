// SPDX-License-Identifier: Apache-2.0
// Suite `stencils`: a prototype of sheets made by stencils on the lattice's own planes, beside the splatter.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

//   stencils [--fill] [--picture] [--scenes] [--large]    without an option the first two; --large takes
//   3.9 GB
int run_stencils_suite(std::span<const std::string> args, const Report& report);

void stencils_fill(const Report& report);    // samples: how near to the field, how fast
void stencils_large(const Report& report);   // the same of 512^3
void stencils_picture(const Report& report); // pictures: time and error beside the splatter's
void stencils_scenes(const Report& report);  // the same of other scenes

} // namespace bccsplat::bench
