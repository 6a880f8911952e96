// SPDX-License-Identifier: Apache-2.0
// Missing data: found in a frame, which is filled there, told as masks, and marked on the lattice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "fit/kept/site_block.h"
#include "fit/resample/fill.h"
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

// Patches `frame` where samples are not finite and returns where that was; to be kept as long as the frame.
// A part of a frame is patched as the whole frame would be, but within the reach of what is not given.
[[nodiscard]] HoleMap patch_holes(Frame& frame, const FrameScan& scan, const AxisFlags& turning,
                                  const FillReach& reach, const Context& context);

// The missing samples of a region as a mask of the file (formats/bcc4/coding/mask_runs.h); dims: of the
// frame. Empty where none is missing.
[[nodiscard]] std::vector<std::byte> mask_runs(const HoleMap& holes, const std::array<int64_t, 3>& dims,
                                               const Region& region);

// Returns the missing samples with nothing but missing ones in the box of `reach` samples on either side;
// near the ends of `turning` axes none.
[[nodiscard]] HoleMap deep_holes(const HoleMap& holes, const std::array<int64_t, 3>& dims,
                                 const std::array<int64_t, 3>& reach, const AxisFlags& turning,
                                 const Context& context);

// The sites whose nearest source sample is missing (the later one of two at equal distance).
[[nodiscard]] SiteMasks mark_sites(const HoleMap& holes, const Lattice4& lattice);

} // namespace bccsplat
