// What a random moment of a series costs: layers decoded, bytes read, processor time, memory; from files of
// samples, of coefficients, and from raw frames in memory.
#pragma once

#include <cstdint>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// edge: voxels along each axis of space.
void moment_tables(uint32_t edge, const Report& report);

} // namespace bccsplat::bench
