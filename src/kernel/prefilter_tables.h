// SPDX-License-Identifier: Apache-2.0
// The shipped prefilters, designed by `bccsplat_bench kernels --design`; kernel.cpp says what else a kernel
// needs.
#pragma once

#include <string_view>
#include <vector>

#include "kernel/kernel.h"

namespace bccsplat {

struct PrefilterTable {
  std::vector<PrefilterStage> stages4, stages3; // on D4*, on BCC
  double gain = 1;                              // the larger sum of |taps| of the two
};

// Returns the prefilters of a canonical kernel name. Throws internal for a name that has none.
[[nodiscard]] PrefilterTable shipped_prefilters(std::string_view kernel_name);

} // namespace bccsplat
