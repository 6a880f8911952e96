// SPDX-License-Identifier: Apache-2.0
// What every stage may use: threads, the memory budget, and the progress of the call it works for.
#pragma once

#include "base/memory.h"
#include "base/progress.h"
#include "base/tasks.h"

namespace bccsplat {

struct Context {
  Tasks& tasks;
  MemoryBudget& memory;
  Progress& progress;

  [[nodiscard]] Context with(Progress& share) const { return {tasks, memory, share}; }
};

} // namespace bccsplat
