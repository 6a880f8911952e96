// SPDX-License-Identifier: Apache-2.0
#include "smoke/expose.h"

#include <algorithm>

namespace smoke {

namespace {

constexpr float faint = 1 / 256.0f; // of the density at a source

// Averages along one axis, whose n samples are `step` apart; a cell beyond the wall counts as the one at the
// wall.
void average_line(const float* in, float* out, size_t step, int n) {
  for (int i = 0; i < n; ++i) {
    const size_t at = i * step;
    out[at] = 0.5f * in[at] + 0.25f * (in[i > 0 ? at - step : at] + in[i < n - 1 ? at + step : at]);
  }
}

} // namespace

Grid expose(const Grid& density) {
  Grid along_x(density.nx, density.ny, density.nz), along_y = along_x, out = along_x;
  const size_t row = density.nx, plane = row * density.ny;
  const auto at = [](auto& grid, int i, int j, int k) { return grid.samples.data() + grid.index(i, j, k); };
  for (int k = 0; k < density.nz; ++k) {
    for (int j = 0; j < density.ny; ++j)
      average_line(at(density, 0, j, k), at(along_x, 0, j, k), 1, density.nx);
    for (int i = 0; i < density.nx; ++i)
      average_line(at(along_x, i, 0, k), at(along_y, i, 0, k), row, density.ny);
  }
  for (int j = 0; j < density.ny; ++j)
    for (int i = 0; i < density.nx; ++i)
      average_line(at(along_y, i, j, 0), at(out, i, j, 0), plane, density.nz);
  for (float& value : out.samples) value = std::max(0.0f, value - faint) / (1 - faint);
  return out;
}

} // namespace smoke
