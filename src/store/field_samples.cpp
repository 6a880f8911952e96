// SPDX-License-Identifier: Apache-2.0
#include "store/field_samples.h"

#include <algorithm>

namespace bccsplat {
namespace {

constexpr uint64_t points_at_a_time = 1 << 16; // 2 MiB of coordinates

} // namespace

FieldGrid grid_of_frame(const Lattice4& lattice, uint32_t frame) {
  const auto samples = [&](size_t a) { return static_cast<int32_t>(lattice.dims[a]); };
  return {{}, {1, 1, 1}, {samples(0), samples(1), samples(2)}, static_cast<double>(frame)};
}

FieldGrid grid_of_layer(const Lattice4& lattice, int32_t layer) {
  const int coset = lattice.coset(layer);
  const Vec3 origin = lattice.site_position(coset, {0, 0, 0});
  return {origin, lattice.site_position(coset, {1, 1, 1}) - origin, lattice.space.dims(coset),
          lattice.is_static() ? 0 : lattice.layer_frame(layer)};
}

std::vector<float> sample_field(const Field& field, const FieldGrid& grid, const std::string& what,
                                const Context& context) {
  const uint64_t nx = grid.dims[0], ny = grid.dims[1];
  std::vector<float> values(nx * ny * grid.dims[2]);
  const Reservation memory(context.memory, values.size() * sizeof(float), "a layer of a field");
  std::vector<double> points;
  for (uint64_t first = 0; first < values.size(); first += points_at_a_time) {
    const uint64_t count = std::min<uint64_t>(points_at_a_time, values.size() - first);
    points.resize(4 * count);
    for (uint64_t i = 0; i < count; ++i) {
      const uint64_t at = first + i, row = at / nx, plane = row / ny;
      points[4 * i] = grid.origin[0] + grid.step[0] * static_cast<double>(at % nx);
      points[4 * i + 1] = grid.origin[1] + grid.step[1] * static_cast<double>(row % ny);
      points[4 * i + 2] = grid.origin[2] + grid.step[2] * static_cast<double>(plane);
      points[4 * i + 3] = grid.frame;
    }
    if (!field(points, std::span(values).subspan(first, count)))
      fail(Code::cancelled, "the field of ", what, " gave up");
    context.progress.check();
  }
  return values;
}

} // namespace bccsplat
