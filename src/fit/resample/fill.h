// SPDX-License-Identifier: Apache-2.0
// What missing samples of a frame are filled with before the filters run, so that these see no false edge:
// means of ever coarser cells, interpolated back and relaxed towards the mean of the neighbours on every
// level.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/context.h"
#include "lattice/lattice.h"

namespace bccsplat {

// How far away data decide what missing samples are filled with.
struct FillReach {
  int halvings = 0; // of samples to cells, at most; 0: as many as there are, data however far away decide

  // Returns a bounded reach: data go on for so many samples, with ever more air in them, which is all there
  // is behind that.
  [[nodiscard]] static FillReach of(double samples);
  [[nodiscard]] bool bounded() const { return halvings > 0; }
  // The largest cells begin at multiples of this.
  [[nodiscard]] int64_t cell() const { return int64_t{1} << halvings; }
  // Returns how many samples away the furthest lies that decides on one; 0 where that is not bounded.
  [[nodiscard]] int64_t samples() const;
};

// Fills the missing samples of a dense array, x fastest, relative to air. All missing: air. With a bounded
// reach a sample has the same bits in every box of whole cells that has all samples within the reach, or all
// as far as the frame goes.
// Along `turning` axes the last sample leads to the first.
void fill_missing(std::span<float> values, std::span<const uint8_t> missing,
                  const std::array<int64_t, 3>& dims, const Context& context, const AxisFlags& turning = {},
                  const FillReach& reach = {});

} // namespace bccsplat
