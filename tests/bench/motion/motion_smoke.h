// SPDX-License-Identifier: Apache-2.0
// The smoke of examples/simulate_smoke.
#pragma once

#include <cstdint>
#include <optional>

#include "tests/bench/fit/fit_source.h"

namespace bccsplat::bench {

// None where the example was not built with the benchmark.
[[nodiscard]] std::optional<FitSource> simulated_smoke(uint32_t edge, uint32_t frames);

} // namespace bccsplat::bench
