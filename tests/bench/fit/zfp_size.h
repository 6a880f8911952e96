// SPDX-License-Identifier: Apache-2.0
// zfp, for comparison.
#pragma once

#include <cstdint>
#include <optional>

#include "tests/bench/fit/fit_source.h"

namespace bccsplat::bench {

// Bytes that zfp's 4D coder takes for a PSNR (peak: the range), its accuracy halved until it is reached and
// sizes taken straight between its steps; none where zfp is not built in.
[[nodiscard]] std::optional<double> zfp_bytes(const FitSource& source, double psnr);

} // namespace bccsplat::bench
