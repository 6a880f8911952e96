// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Coefficients as integer codes against samples: bytes and errors in smooth and in real fields, and whether
// coefficients may become the default. `data`: the folder of the real sets; those that are not there are
// named and left out.
void coefficient_tables(const std::string& data, const Report& report);

} // namespace bccsplat::bench
