// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "formats/bcc4/encode/round_units.h"

namespace bccsplat {
namespace {

// Calls body for the rows inside the domain, in coding order, with cells for the errors of their sites.
// Beyond the chunk there are none: other chunks are rounded on their own.
template<class Body> void for_unit_rows(const ChunkShape& shape, const Body& body) {
  std::vector<double> cells(3 * layer_cells);
  const auto layer_at = [&](int m) { return cells.data() + (m % 3) * layer_cells; };
  for (int m = 0; m < shape.layers; ++m) {
    std::fill_n(layer_at(m), layer_cells, 0.0);
    const Int3& n = shape.box[m];
    const std::ptrdiff_t lowest = shape.coset(m) == 1 ? 0 : -1 - stride_y - stride_z;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y) {
        const std::ptrdiff_t at = (z + 1) * stride_z + (y + 1) * stride_y + 1;
        body(Row<double>{m, z * brick_edge + y, n[0], layer_at(m) + at,
                         shape.has_cross(m) ? layer_at(m - 1) + at + lowest : nullptr,
                         shape.has_previous(m) ? layer_at(m - shape.period) + at : nullptr});
      }
  }
}

} // namespace

void round_units_reference(const ChunkShape& shape, std::span<const Brick* const> bricks,
                           const UnitRounding& how, std::span<LayerUnits> units) {
  for_unit_rows(shape, [&](const Row<double>& row) {
    const size_t m = row.layer;
    if (!bricks[m]) return;
    std::array<const double*, max_taps> taps;
    const size_t n = how.weights.empty() ? 0 : gather_taps(row, taps);
    const size_t first = static_cast<size_t>(row.index) * brick_edge;
    for (int x = 0; x < row.width; ++x) {
      const double value = bricks[m]->value[first + x];
      int32_t& to = units[m][first + x];
      to = 0;
      if (value == 0) continue;
      double wanted = 0;
      for (size_t i = 0; i < n; ++i) wanted += how.weights[m][i] * taps[i][x];
      wanted = wanted / (1 << fraction_bits) + value;
      const double rounded = std::clamp(std::floor(wanted / how.unit + 0.5), -how.most, how.most);
      row.own[x] = rounded * how.unit - wanted;
      to = static_cast<int32_t>(rounded);
    }
  });
}

} // namespace bccsplat
