#include "slice/sample_grid.h"

#include <atomic>
#include <vector>

namespace bccsplat {

EvaluateMisses sample_points(const Slice& slice, std::span<const Vec3> points, std::span<float> values,
                             std::span<std::array<float, 3>> gradients, const Context& context) {
  constexpr uint64_t block = 4096;
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

void sample_grid(const Slice& slice, const Grid& grid, float* values, const Context& context) {
  const Affine3 to_lattice = slice.lattice_to_slice.inverse();
  const auto nx = static_cast<uint64_t>(grid.dims[0]), ny = static_cast<uint64_t>(grid.dims[1]);
  context.tasks.parallel_for(ny * static_cast<uint64_t>(grid.dims[2]), [&](uint64_t row) {
    context.progress.check();
    std::vector<Vec3> at(nx);
    const double y = grid.origin[1] + grid.step[1] * static_cast<double>(row % ny);
    const double z = grid.origin[2] + grid.step[2] * static_cast<double>(row / ny);
    for (uint64_t x = 0; x < nx; ++x)
      at[x] = to_lattice.point({grid.origin[0] + grid.step[0] * static_cast<double>(x), y, z});
    evaluate(slice, at, {values + row * nx, nx}, {});
  });
}

uint64_t list_points(const Slice& slice, uint64_t capacity, float* positions, float* coefficients) {
  uint64_t n = 0;
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    const BrickLayer& layer = slice.coset[static_cast<size_t>(c)];
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      const Brick* brick = layer.brick(s);
      if (!brick) continue;
      const Int3 b = layer.slot_position(s);
      for (int row = 0; row < brick_rows; ++row)
        for (int x = 0; x < brick_edge; ++x) {
          if (!(brick->kept[static_cast<size_t>(row)] >> x & 1)) continue;
          const uint64_t i = n++;
          if (i >= capacity) continue;
          if (coefficients) coefficients[i] = brick->value[static_cast<size_t>(row * brick_edge + x)];
          if (!positions) continue;
          const Vec3 p = slice.lattice_to_slice.point(
              slice.site(c, {b[0] * brick_edge + x, b[1] * brick_edge + row % brick_edge,
                             b[2] * brick_edge + row / brick_edge}));
          for (size_t a = 0; a < 3; ++a) positions[3 * i + a] = static_cast<float>(p[a]);
        }
    }
  }
  return n;
}

} // namespace bccsplat
