// SPDX-License-Identifier: Apache-2.0
// What the encoder settles: the chain, its steps, and which neighbours tell what comes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/bench/coder/steps.h"
#include "tests/bench/coder/trial_coder.h"
#include "tests/bench/coder/trial_head.h"

namespace bccsplat::bench {

struct TrialPlan {
  TrialHead head;
  std::vector<Slab> slabs; // with their steps
  bool principal = false;  // their bases are of their own, not cosines
  double bits = 0;         // by a rough forecast
  [[nodiscard]] std::string words() const;
};

// Chooses how often each axis is halved and the basis of time, and finds the step whose mean square error is
// the wanted one. `filled`: the series without holes, whose frames the head describes.
[[nodiscard]] TrialPlan plan_trial(const TrialSeries& series, const TrialSeries& filled,
                                   const TrialHead& head, double mean_square, double lambda);
[[nodiscard]] std::span<const float> source_of(const TrialHead& head, const Slab& slab,
                                               const TrialSeries& series);
// What a reader gets of a slab, but for its details.
[[nodiscard]] std::vector<float> restored_slab(const TrialHead& head, const Slab& slab);

} // namespace bccsplat::bench
