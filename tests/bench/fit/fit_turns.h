// SPDX-License-Identifier: Apache-2.0
// What an axis that is periodic gains over one that ends.
#pragma once

#include <cstddef>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Plane waves that go round a whole number of times along an axis (3: time), through whole files with the
// ends of the axis mirrored, predicted and periodic: values and gradients by distance from the ends, and
// between the last sample and the first.
void report_turns(size_t axis, const Report& report);

} // namespace bccsplat::bench
