// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

// Slices of every kind: time against a memory copy, cost against points touched, error against the field, the
// paper's own methods, and what a file has to read. --volumes D4.bcc4,CC.bcc4: the paper's count of relevant
// points on files of the same series, instead.
int run_slice_suite(std::span<const std::string> args, const Report& report);

} // namespace bccsplat::bench
