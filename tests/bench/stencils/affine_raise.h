// SPDX-License-Identifier: Apache-2.0
// Sheets of samples brought to the pixels of a tile by an affine map, in two passes: along rows of samples to
// the columns of pixels, then along each of these columns to the pixels. Rows are as far apart as they like;
// each has its own phase. Both passes turn rows into columns, so that both read along rows.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/raise/raise_fan.h"

namespace bccsplat::bench {

inline constexpr int raise_block = 16;     // pixels a side
inline constexpr int most_raised = 4;      // sheets at once: they share places and weights
inline constexpr int raise_phase_bits = 6; // places are rounded to 1/64 of a sample
inline constexpr int raise_phases = 1 << raise_phase_bits;

// Rows that run over samples at `slope` samples per pixel, by the phase they start at.
class RaiseRows {
 public:
  void prepare(int taps, double density, double slope, int count);
  // Where a row that starts at sample `start` reads: the table, and the sample that its samples count from.
  struct Start {
    const RaiseAxis* table;
    int whole;
  };
  [[nodiscard]] Start at(double start) const;

 private:
  std::vector<RaiseAxis> table_;
};

// Pixels n .. n + 15 of rows r .. r + 15 of several sheets.
struct RaiseBlock {
  int taps = 0, sheets = 0;
  const float* source[most_raised][raise_block] = {}; // what the row's samples count from
  const int32_t* sample[raise_block] = {};            // at pixel n
  const float* weight[raise_block] = {};              // at pixel n of tap 0
  size_t weight_pitch = 0;
  float* out[most_raised] = {}; // pixel n of row r goes to out[n * out_pitch + r]
  std::ptrdiff_t out_pitch = 0;
};
void raise_block_reference(const RaiseBlock& block);
void raise_turned(const RaiseBlock& block); // best target of this machine

} // namespace bccsplat::bench
