// SPDX-License-Identifier: Apache-2.0
// Missing data: filled smoothly before resampling, so that the filter sees no false edge, and marked on the
// lattice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "fit/kept/site_block.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Tells which samples of a region of a frame are missing.
struct HoleMap {
  Region region;
  std::vector<uint8_t> missing; // 1 where missing, x fastest; empty: none
  Reservation memory;           // of the map and of the frame's patch
  [[nodiscard]] bool at(int64_t x, int64_t y, int64_t z) const;
  [[nodiscard]] HoleMap copy(MemoryBudget& budget) const;
};

// Gives the missing samples of a dense array (x fastest) a smooth continuation of those around them: means of
// ever coarser cells, interpolated back and relaxed towards the mean of the neighbours on every level. All
// missing: 0.
// Along `turning` axes the last sample leads to the first.
void fill_missing(std::span<float> values, std::span<const uint8_t> missing,
                  const std::array<int64_t, 3>& dims, const Context& context, const AxisFlags& turning = {});

// Patches `frame` where samples are not finite and returns where that was; to be kept as long as the frame.
[[nodiscard]] HoleMap patch_holes(Frame& frame, const FrameScan& scan, const AxisFlags& turning,
                                  const Context& context);

// The missing samples as a mask of the file (formats/bcc4/coding/mask_runs.h); dims: of the frame.
[[nodiscard]] std::vector<std::byte> mask_runs(const HoleMap& holes, const std::array<int64_t, 3>& dims);

// Returns the missing samples with nothing but missing ones in the box of `reach` samples on either side;
// near the ends of `turning` axes none.
[[nodiscard]] HoleMap deep_holes(const HoleMap& holes, const std::array<int64_t, 3>& dims,
                                 const std::array<int64_t, 3>& reach, const AxisFlags& turning,
                                 const Context& context);

// The sites whose nearest source sample is missing (the later one of two at equal distance).
[[nodiscard]] SiteMasks mark_sites(const HoleMap& holes, const Lattice4& lattice);

} // namespace bccsplat
