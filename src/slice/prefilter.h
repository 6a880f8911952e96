// One prefilter stage on one layer, brick by brick: a 25-point stencil on D4*, 15 points on BCC.
#pragma once

#include "base/context.h"
#include "kernel/kernel.h"
#include "points/brick.h"

namespace bccsplat {

// The layers a stage reads. own: the layer itself; before, after: the next layers of the same coset (null:
// none, as on a static lattice); cross: the neighbouring layers of the other coset (one or both may be null).
struct StageInput {
  const BrickLayer* own = nullptr;
  const BrickLayer* before = nullptr;
  const BrickLayer* after = nullptr;
  const BrickLayer* cross_before = nullptr;
  const BrickLayer* cross_after = nullptr;
};

// Applies the stage to every site in whose reach something is stored. Kept bits and holes are not set: see
// finish_coefficients.
[[nodiscard]] BrickLayer apply_stage(const PrefilterStage& stage, const StageInput& input,
                                     const Context& context);

// Marks the coefficients that matter (|c| > prune, in value units) and takes over the holes of the samples.
[[nodiscard]] BrickLayer finish_coefficients(const BrickLayer& coefficients, const BrickLayer& samples,
                                             float prune, const Context& context);

} // namespace bccsplat
