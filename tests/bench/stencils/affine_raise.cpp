// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/stencils/affine_raise.h"

#include <cmath>

namespace bccsplat::bench {

void RaiseRows::prepare(int taps, double density, double slope, int count) {
  RaiseFan fan;
  fan.taps = taps;
  make_fan_weights(fan, density);
  table_.resize(raise_phases);
  // A row of slope < 0 runs down its samples: its table is that of places that fall.
  for (int p = 0; p < raise_phases; ++p) {
    RaiseAxis& axis = table_[p];
    fan_axis(fan, {slope, -p / (raise_phases * slope)}, 1, 0, count, axis);
  }
}

RaiseRows::Start RaiseRows::at(double start) const {
  const auto units = static_cast<int64_t>(std::floor(start * raise_phases + 0.5));
  return {&table_[units & (raise_phases - 1)], static_cast<int>(units >> raise_phase_bits)};
}

void raise_block_reference(const RaiseBlock& b) {
  for (int s = 0; s < b.sheets; ++s)
    for (int r = 0; r < raise_block; ++r)
      for (int n = 0; n < raise_block; ++n) {
        float sum = 0;
        for (int t = 0; t < b.taps; ++t)
          sum += b.weight[r][t * b.weight_pitch + n] * b.source[s][r][b.sample[r][n] + t];
        b.out[s][n * b.out_pitch + r] = sum;
      }
}

} // namespace bccsplat::bench
