// One prefilter stage on one layer, brick by brick (formula: PrefilterStage in kernel/kernel.h).
#pragma once

#include "base/context.h"
#include "kernel/kernel.h"
#include "points/brick.h"
#include "points/sample_source.h"

namespace bccsplat {

// The layers a stage reads; null: none, as before and after on a static lattice.
struct StageLayers {
  const BrickLayer* own = nullptr;
  const BrickLayer* before = nullptr; // the next layers of the same coset
  const BrickLayer* after = nullptr;
};
struct StageInput {
  StageLayers previous; // c: what the stage before made
  StageLayers samples;  // f: looked at when the stage uses them
  // c in the neighbouring layers of the other coset; on CC cross_after is f itself, of the own layer.
  const BrickLayer* cross_before = nullptr;
  const BrickLayer* cross_after = nullptr;
};

// The last stage also keeps coefficients that matter (|c| > prune, in value units), clears the others, and
// takes over the holes of the samples.
struct StageFinish {
  const BrickLayer* samples;
  float prune;
};

// Applies the stage, in the bricks of `region`, to every site in whose reach something is stored. Kept bits
// and holes are not set without `finish`.
[[nodiscard]] BrickLayer apply_stage(const PrefilterStage& stage, const StageInput& input,
                                     const StageFinish* finish, const BrickBox& region,
                                     const Context& context);

} // namespace bccsplat
