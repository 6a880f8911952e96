// SPDX-License-Identifier: Apache-2.0
// The law of absorption.
#pragma once

#include <cmath>

namespace bccsplat {

// The opacity of an optical depth x >= 0: 1 - exp(-x).
[[nodiscard]] inline float absorbed(float x) { return -std::expm1(-x); }

} // namespace bccsplat
