// SPDX-License-Identifier: Apache-2.0
// A GPU for tests: Mesa's rasteriser on the CPU where there is no card.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "gpu/gpu_device.h"

namespace bccsplat::test {

// Returns null, and says why, where there is none.
inline std::shared_ptr<GpuDevice> test_gpu(GpuEntry entry, uint64_t memory_limit = 0, bool as_card = false) {
  GpuWishes wishes;
  wishes.as_card = as_card;
  wishes.entry = entry, wishes.software_too = true, wishes.memory_limit = memory_limit;
  auto gpu = std::make_shared<GpuDevice>(wishes);
  try {
    (void)gpu->info();
    return gpu;
  } catch (const GpuFailure& e) {
    std::fprintf(stderr, "NOT TESTED, no GPU: %s\n", e.what());
    return nullptr;
  }
}

} // namespace bccsplat::test
