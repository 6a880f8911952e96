// SPDX-License-Identifier: Apache-2.0
// Lattice samples that a producer gives directly, in the form the rest of the fit works on.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "fit/frame/frame.h"
#include "fit/kept/site_block.h"
#include "points/brick.h"

namespace bccsplat {

struct DirectLayerScan {
  uint64_t finite = 0, nonfinite = 0;
  double low = 0, high = 0;   // absolute range of the finite samples
  size_t first_nonfinite = 0; // index of the sample
};
[[nodiscard]] DirectLayerScan scan_layer(std::span<const float> samples, float air);

// Absolute samples, x fastest, as blocks relative to air; all-air bricks are null. Samples that are not
// finite become holes, or (NonFinite::clamp) air and the ends of `clamp`, which are relative to air.
[[nodiscard]] FrameSites layer_sites(const BrickLayer& shape, std::span<const float> samples, float air,
                                     NonFinite policy, const std::array<float, 2>& clamp, SiteBlockPool& pool,
                                     const Context& context);

} // namespace bccsplat
