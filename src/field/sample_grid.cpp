// SPDX-License-Identifier: Apache-2.0
// Samples a slice on a dense grid in tiles: sites are copied once per tile, weights along an axis are shared
// by all its rows.
#include "field/sample_grid.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "field/footprint/dense_sites.h"
#include "field/footprint/grid_rows.h"
#include "kernel/cc_kernel.h"

namespace bccsplat {
namespace {

// A stretch of samples along an axis.
struct Stretch {
  size_t begin, count;
};

// One axis of the grid: where its samples lie on the lattice, and how they are cut into tiles.
struct GridAxis {
  std::vector<double> position; // lattice units; those outside are moved to the end of the domain
  std::vector<uint8_t> outside;
  std::array<AxisSamples, 2> samples; // per coset
  std::vector<Stretch> tiles;

  [[nodiscard]] size_t size() const { return position.size(); }
  // Sites of the tile's patches along this axis: first, and how many.
  [[nodiscard]] std::array<int, 2> sites(size_t coset, const Stretch& tile, int edge) const {
    const auto from = samples[coset].first.begin() + tile.begin;
    const auto [low, high] = std::minmax_element(from, from + tile.count);
    return {*low, *high - *low + edge};
  }
};

GridAxis grid_axis(const Slice& slice, const FootprintPlan& plan, const Grid& grid, size_t axis) {
  // Tiles are long in x, where weights are found once for all rows, and so small that the sites under them
  // fit a box that gather_box copies.
  constexpr size_t tile_samples[] = {256, 8, 1};
  constexpr int tile_sites[] = {480, 32, 32};
  const double unit = slice.lattice_to_slice.linear[axis][axis];
  const double begin = slice.domain_begin[axis], end = slice.domain_end[axis],
               tolerance = domain_tolerance(end);
  GridAxis a;
  const size_t n = grid.dims[axis];
  a.position.reserve(n), a.outside.reserve(n);
  for (size_t i = 0; i < n; ++i) {
    const double p =
        (grid.origin[axis] + grid.step[axis] * static_cast<double>(i) - slice.lattice_to_slice.offset[axis]) /
        unit;
    a.outside.push_back(!(p >= begin - tolerance && p <= end + tolerance));
    a.position.push_back(std::clamp(p, begin, end));
  }
  for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c)
    a.samples[c] = axis_samples(plan, c, axis, a.position);
  const auto& first = a.samples[0].first;
  for (size_t i = 0; i < n;) {
    size_t end_of_tile = i + 1;
    while (end_of_tile < n && end_of_tile - i < tile_samples[axis] &&
           std::abs(first[end_of_tile] - first[i]) < tile_sites[axis])
      ++end_of_tile;
    a.tiles.push_back({i, end_of_tile - i});
    i = end_of_tile;
  }
  return a;
}

// The parts of a dense grid whose axes are those of the lattice.
struct GridSampler {
  const Slice& slice;
  const FootprintPlan& plan;
  std::array<GridAxis, 3> axis;

  // Samples of one z and one tile of y, all x.
  void rows(size_t z, const Stretch& y_tile, float* values) const {
    std::array<std::vector<float>, 2> sites;
    std::array<float, 256 + grid_row_padding> sums;
    std::vector<SiteRow> near;
    for (const Stretch& x_tile : axis[0].tiles) {
      std::array<SiteBox, 2> box;
      std::array<bool, 2> any{};
      for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c) {
        const auto along_x = axis[0].sites(c, x_tile, patch_edge);
        const auto along_y = axis[1].sites(c, y_tile, plan.edge);
        box[c] = {{along_x[0], along_y[0], axis[2].samples[c].first[z]}, {along_x[1], along_y[1], plan.edge}};
        size_t count = grid_row_padding;
        count += static_cast<size_t>(along_x[1]) * along_y[1] * plan.edge;
        if (sites[c].size() < count) sites[c].resize(count);
        any[c] = gather_box(*plan.coset[c].layer[0], box[c], sites[c].data());
      }
      for (size_t y = y_tile.begin; y < y_tile.begin + y_tile.count; ++y) {
        std::fill_n(sums.begin(), x_tile.count, 0.0f);
        for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c) {
          if (!any[c]) continue;
          near_rows(c, box[c], sites[c].data(), y, z, near);
          const auto& x = axis[0].samples[c];
          add_grid_row(plan, near, box[c].origin[0], std::span(x.first).subspan(x_tile.begin, x_tile.count),
                       x.from.data() + x_tile.begin, sums.data());
        }
        float* out = values + (z * axis[1].size() + y) * axis[0].size() + x_tile.begin;
        for (size_t i = 0; i < x_tile.count; ++i) out[i] = slice.base + sums[i];
        finish(x_tile, y, z, out);
      }
    }
  }

 private:
  // The rows of sites within the kernel's radius of a row of samples.
  void near_rows(size_t c, const SiteBox& box, const float* sites, size_t y, size_t z,
                 std::vector<SiteRow>& near) const {
    near.clear();
    const AxisSamples &sy = axis[1].samples[c], &sz = axis[2].samples[c];
    for (int k = 0; k < plan.edge; ++k)
      for (int j = 0; j < plan.edge; ++j) {
        const float dy = sy.from[y] - static_cast<float>(j), dz = sz.from[z] - static_cast<float>(k);
        const float u = 1 - plan.inverse_radius2 * (dy * dy + dz * dz);
        if (!(u > 0)) continue;
        const int row = k * box.size[1] + sy.first[y] - box.origin[1] + j;
        near.push_back({sites + static_cast<size_t>(row) * box.size[0], u});
      }
  }

  void finish(const Stretch& x_tile, size_t y, size_t z, float* out) const {
    constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
    const bool row_outside = axis[1].outside[y] || axis[2].outside[z];
    const bool by_point = !slice.clip.empty() || slice.has_holes || plan.kernel->normalised;
    for (size_t i = 0; i < x_tile.count; ++i) {
      const size_t x = x_tile.begin + i;
      bool none = row_outside || axis[0].outside[x];
      if (by_point && !none) {
        const Vec3 p{axis[0].position[x], axis[1].position[y], axis[2].position[z]};
        none = !slice.inside(p) || slice.is_hole(p);
        if (!none && plan.kernel->normalised) {
          const double sum = lattice_sum(*plan.kernel, plan.bcc, p[0], p[1], p[2]);
          out[i] = static_cast<float>(slice.base + (out[i] - slice.base) / sum);
        }
      }
      if (none) out[i] = nan_value;
    }
  }
};

bool axes_aligned(const Affine3& a) {
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c)
      if ((a.linear[r][c] != 0) != (r == c)) return false;
  return true;
}

} // namespace

EvaluateMisses sample_points(const Slice& slice, std::span<const Vec3> points, std::span<float> values,
                             std::span<std::array<float, 3>> gradients, const Context& context) {
  constexpr uint64_t block = 4096; // points of a task
  const Affine3 to_lattice = slice.lattice_to_slice.inverse();
  std::atomic<uint64_t> outside{0}, holes{0};
  context.tasks.parallel_for((points.size() + block - 1) / block, [&](uint64_t b) {
    context.progress.check();
    const uint64_t begin = b * block, count = std::min<uint64_t>(block, points.size() - begin);
    std::vector<Vec3> at(count);
    for (uint64_t i = 0; i < count; ++i) at[i] = to_lattice.point(points[begin + i]);
    const auto slopes = gradients.empty() ? gradients : gradients.subspan(begin, count);
    const EvaluateMisses m = evaluate(slice, at, values.subspan(begin, count), slopes);
    for (auto& g : slopes) { // per lattice unit -> per unit of slice space
      const Vec3 v = to_lattice.transposed({g[0], g[1], g[2]});
      g = {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
    }
    outside += m.outside, holes += m.holes;
  });
  return {outside, holes};
}

uint64_t hide_missing(const Slice& slice, std::span<const Vec3> points, std::span<float> values) {
  uint64_t hidden = 0;
  for (size_t i = 0; slice.mask && i < points.size(); ++i) {
    if (std::isnan(values[i]) || !slice.mask->missing(points[i])) continue;
    values[i] = std::numeric_limits<float>::quiet_NaN();
    ++hidden;
  }
  return hidden;
}

void sample_grid(const Slice& slice, const Grid& grid, float* values, const Context& context) {
  const uint64_t ny = grid.dims[1], nz = grid.dims[2];
  if (!axes_aligned(slice.lattice_to_slice)) {
    const uint64_t nx = grid.dims[0];
    context.tasks.parallel_for(ny * nz, [&](uint64_t row) {
      context.progress.check();
      std::vector<Vec3> at(nx);
      for (uint64_t x = 0; x < nx; ++x) {
        const Vec3 i{static_cast<double>(x), static_cast<double>(row % ny), static_cast<double>(row / ny)};
        for (size_t a = 0; a < 3; ++a) at[x][a] = grid.origin[a] + grid.step[a] * i[a];
      }
      sample_points(slice, at, {values + row * nx, at.size()}, {}, context);
    });
    return;
  }
  const std::array<FieldLayer, 2> layers{FieldLayer{&slice.coset[0]}, FieldLayer{&slice.coset[1]}};
  const FootprintPlan plan({std::span(layers).first(slice.lattice.cosets()), &slice.kernel});
  GridSampler sampler{slice, plan, {}};
  for (size_t a = 0; a < 3; ++a) sampler.axis[a] = grid_axis(slice, plan, grid, a);
  const auto& y_tiles = sampler.axis[1].tiles;
  context.tasks.parallel_for(y_tiles.size() * nz, [&](uint64_t task) {
    context.progress.check();
    sampler.rows(task / y_tiles.size(), y_tiles[task % y_tiles.size()], values);
  });
  if (slice.corrections) slice.corrections->add_to_grid(grid.origin, grid.step, grid.dims, values);
}

namespace {

// Calls body(coset, site, coefficient relative to the base) for every site that is kept, brick by brick.
template<class Body> void for_kept_sites(const Slice& slice, const Body& body) {
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    const BrickLayer& layer = slice.coset[c];
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      const Brick* brick = layer.brick(s);
      if (!brick) continue;
      const Int3 b = layer.slot_position(s);
      for (int row = 0; row < brick_rows; ++row)
        for (int x = 0; x < brick_edge; ++x)
          if (brick->kept[row] >> x & 1)
            body(c,
                 Int3{b[0] * brick_edge + x, b[1] * brick_edge + row % brick_edge,
                      b[2] * brick_edge + row / brick_edge},
                 brick->value[row * brick_edge + x]);
    }
  }
}

// The same for all sites, row by row.
template<class Body> void for_sites(const Slice& slice, const Body& body) {
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    const BrickLayer& layer = slice.coset[c];
    for (int z = 0; z < layer.dims()[2]; ++z)
      for (int y = 0; y < layer.dims()[1]; ++y)
        for (int x = 0; x < layer.dims()[0]; ++x) body(c, Int3{x, y, z}, layer.value(x, y, z));
  }
}

} // namespace

uint64_t list_points(const Slice& slice, uint64_t capacity, float* positions, float* coefficients,
                     Progress& progress) {
  constexpr uint64_t points_per_check = 4096;
  const float above_air = slice.base - slice.air;
  uint64_t n = 0;
  const auto list = [&](int coset, const Int3& site, float coefficient) {
    const uint64_t i = n++;
    if (i % points_per_check == 0) progress.check();
    if (i >= capacity) return;
    if (coefficients) coefficients[i] = above_air + coefficient;
    if (!positions) return;
    const Vec3 p = slice.lattice_to_slice.point(slice.site(coset, site));
    for (size_t a = 0; a < 3; ++a) positions[3 * i + a] = static_cast<float>(p[a]);
  };
  // Where the base is not air no site is air, not even where its coefficient is that of the base.
  if (slice.base == slice.air)
    for_kept_sites(slice, list);
  else
    for_sites(slice, list);
  return n;
}

} // namespace bccsplat
