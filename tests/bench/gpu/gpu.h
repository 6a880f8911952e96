// SPDX-License-Identifier: Apache-2.0
// Suite `gpu`: pictures by the GPU beside ray-marchers of 3D textures that share its march, tables and light.
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

int run_gpu_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
