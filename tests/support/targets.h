// SPDX-License-Identifier: Apache-2.0
// Every instruction set of this machine that the core was compiled for.
#pragma once

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>

namespace bccsplat::test {

// Runs `body` once per target, under that target; whatever ends it, the best one is chosen again.
template<class Body> void for_targets(const Body& body) {
  struct Chosen {
    ~Chosen() { choose(0); }
    static void choose(int64_t targets) { // 0: all
      hwy::SetSupportedTargetsForTest(targets);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
  } chosen;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    Chosen::choose(target);
    body();
  }
}

} // namespace bccsplat::test
