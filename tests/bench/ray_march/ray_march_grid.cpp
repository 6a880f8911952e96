// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/bench/ray_march/march_spline.h"
#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {
namespace {

int mirrored(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1);
  i = ((i % period) + period) % period;
  return i < n ? i : period - i;
}

} // namespace

MarchGrid make_march_grid(const Int3& dims, const std::function<double(double x, double y, double z)>& field,
                          Interpolation interpolation) {
  MarchGrid g;
  g.dims = dims, g.interpolation = interpolation;
  const auto padded = [&](size_t a) { return static_cast<size_t>(dims[a] + 2 * MarchGrid::pad); };
  g.row = padded(0), g.plane = g.row * padded(1);
  g.origin = MarchGrid::pad * (g.plane + g.row + 1);
  g.value.resize(g.plane * padded(2) + 1);
  for (int z = 0; z < dims[2]; ++z)
    for (int y = 0; y < dims[1]; ++y)
      for (int x = 0; x < dims[0]; ++x) g.value[g.at(x, y, z)] = static_cast<float>(field(x, y, z));
  if (interpolation == Interpolation::tricubic) make_spline_coefficients(g);
  for (int z = -MarchGrid::pad; z < dims[2] + MarchGrid::pad; ++z)
    for (int y = -MarchGrid::pad; y < dims[1] + MarchGrid::pad; ++y)
      for (int x = -MarchGrid::pad; x < dims[0] + MarchGrid::pad; ++x) {
        const Int3 from{mirrored(x, dims[0]), mirrored(y, dims[1]), mirrored(z, dims[2])};
        g.value[g.at(x, y, z)] = g.value[g.at(from[0], from[1], from[2])];
      }
  constexpr int edge = MarchGrid::cell_edge;
  for (size_t a = 0; a < 3; ++a) g.cells[a] = (dims[a] + edge - 1) / edge;
  for (int z = 0; z < g.cells[2]; ++z)
    for (int y = 0; y < g.cells[1]; ++y)
      for (int x = 0; x < g.cells[0]; ++x) {
        if (interpolation == Interpolation::tricubic) {
          const auto [low, high] = spline_bounds(g, {x, y, z});
          g.low.push_back(low), g.high.push_back(high);
          continue;
        }
        float low = g.value[g.at(x * edge, y * edge, z * edge)], high = low;
        for (int k = z * edge; k <= std::min((z + 1) * edge, dims[2]); ++k)
          for (int j = y * edge; j <= std::min((y + 1) * edge, dims[1]); ++j)
            for (int i = x * edge; i <= std::min((x + 1) * edge, dims[0]); ++i)
              low = std::min(low, g.value[g.at(i, j, k)]), high = std::max(high, g.value[g.at(i, j, k)]);
        g.low.push_back(low), g.high.push_back(high);
      }
  return g;
}

Slice grid_domain(const MarchGrid& grid) {
  Slice s;
  s.lattice.bcc = false;
  for (size_t a = 0; a < 3; ++a) {
    s.lattice.last[a] = std::max(grid.dims[a] - 1, 1);
    s.domain_end[a] = grid.dims[a] - 1;
    s.basis[a][a] = 1;
  }
  s.bounds = {static_cast<double>(*std::min_element(grid.low.begin(), grid.low.end())),
              static_cast<double>(*std::max_element(grid.high.begin(), grid.high.end()))};
  return s;
}

ClassTable march_table(const MarchScene& scene, const MarchOptions& options) {
  const Slice domain = grid_domain(*scene.grid);
  const double unit = scene.function.unit_distance > 0 ? scene.function.unit_distance : 1;
  return make_class_table(scene.function, domain.bounds[0], domain.bounds[1], 0, unit, options.table_entries);
}

std::vector<uint8_t> march_distances(const MarchGrid& grid, const TransferFunction& function,
                                     const MarchOptions& options) {
  MarchScene scene;
  scene.grid = &grid, scene.function = function;
  const ClassTable table = march_table(scene, options);
  constexpr int farthest = 255;
  std::vector<uint8_t> distance(grid.low.size());
  for (size_t c = 0; c < distance.size(); ++c) {
    const double low = grid.low[c], high = grid.high[c];
    const bool shows = options.mode == RenderMode::isosurface
                           ? low < options.iso_value && options.iso_value <= high
                           : table.visible(low, high);
    distance[c] = shows ? 0 : farthest;
  }
  // In the maximum norm distances follow axis by axis from the neighbours, two sweeps of 13 each.
  const Int3 n = grid.cells;
  const auto sweep = [&](int direction) {
    const auto total = static_cast<int>(distance.size());
    for (int s = 0; s < total; ++s) {
      const int c = direction > 0 ? s : total - 1 - s;
      const int x = c % n[0], y = c / n[0] % n[1], z = c / (n[0] * n[1]);
      int best = distance[c];
      for (int k = std::max(z - 1, 0); k <= std::min(z + 1, n[2] - 1); ++k)
        for (int j = std::max(y - 1, 0); j <= std::min(y + 1, n[1] - 1); ++j)
          for (int i = std::max(x - 1, 0); i <= std::min(x + 1, n[0] - 1); ++i)
            best = std::min(best, distance[(k * n[1] + j) * n[0] + i] + 1);
      distance[c] = static_cast<uint8_t>(std::min(best, farthest));
    }
  };
  sweep(1), sweep(-1);
  distance.resize(distance.size() + 3); // four bytes are read at once
  return distance;
}

} // namespace bccsplat::bench
