// SPDX-License-Identifier: Apache-2.0
// The shipped prefilters; kernel.cpp says what else a kernel needs, tests/bench/notes/kernels.md how they
// were designed.
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
