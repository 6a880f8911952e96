// SPDX-License-Identifier: Apache-2.0
// Series whose holes are filled, so that they can be transformed.
#pragma once

#include "tests/bench/coder/trial_coder.h"

namespace bccsplat::bench {

// What fills holes: the mean of the neighbours that are known, from the rims inwards. Throws invalid_argument
// where nothing is known.
[[nodiscard]] TrialSeries without_holes(const TrialSeries& series);

} // namespace bccsplat::bench
