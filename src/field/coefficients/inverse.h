// The stage of a Cartesian prefilter that has a pole: it inverts, along x, y and z, what a kernel makes of
// coefficients at the sites (PrefilterStage in kernel/kernel.h).
#pragma once

#include "base/context.h"
#include "field/coefficients/prefilter.h"

namespace bccsplat {

// As apply_stage().
[[nodiscard]] BrickLayer apply_inverse(const PrefilterStage& stage, const BrickLayer& from,
                                       const StageFinish* finish, const BrickBox& region,
                                       const Context& context);

} // namespace bccsplat
