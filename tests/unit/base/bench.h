// SPDX-License-Identifier: Apache-2.0
// Threads, memory and progress for one test.
#pragma once

#include <cstdint>

#include "base/context.h"

namespace bccsplat::test {

struct Bench {
  explicit Bench(int threads = 1, uint64_t budget = UINT64_MAX) : tasks(threads), memory(budget) {}
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  Context context{tasks, memory, progress};
};

} // namespace bccsplat::test
