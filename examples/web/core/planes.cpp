// SPDX-License-Identifier: Apache-2.0
// Values on the x, y and z plane through a point of the moment that is drawn.
#include <emscripten.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "viewer.h"

using namespace web;

namespace {

using Place = std::array<double, 3>;

// Samples `counts` values along each axis from one place to another, x fastest; places are fractions of the
// domain.
void sample(const Place& from, const Place& to, const std::array<int, 3>& counts, float* values) {
  auto info = sized<bccsplat_slice_info>();
  check(bccsplat_slice_get_info(viewer.moment.slice.get(), &info));
  auto grid = sized<bccsplat_grid>();
  for (size_t a = 0; a < 3; ++a) {
    const double across = info.extent[a][1] - info.extent[a][0];
    grid.dims[a] = static_cast<uint64_t>(counts[a]);
    grid.origin[a] = info.extent[a][0] + from[a] * across;
    grid.step[a] = (to[a] - from[a]) * across / std::max(counts[a] - 1, 1);
    if (grid.step[a] <= 0) grid.step[a] = 1;
  }
  if (!viewer.samples.slice)
    return check(bccsplat_slice_sample_grid(viewer.moment.slice.get(), &grid, values));
  // Labels: those of the samples whose indices are nearest, as everywhere.
  std::vector<double> places;
  const uint64_t nx = grid.dims[0], ny = grid.dims[1], count = nx * ny * grid.dims[2];
  for (uint64_t n = 0; n < count; ++n) {
    const std::array<uint64_t, 3> at{n % nx, n / nx % ny, n / nx / ny};
    for (size_t row = 0; row < 3; ++row) {
      double world = info.affine[4 * row + 3];
      for (size_t a = 0; a < 3; ++a)
        world += info.affine[4 * row + a] * (grid.origin[a] + grid.step[a] * static_cast<double>(at[a]));
      places.push_back(world);
    }
  }
  check(bccsplat_volume_world_to_index(viewer.volume.get(), count, places.data(), places.data()));
  const auto status =
      bccsplat_slice_evaluate(viewer.samples.slice.get(), count, places.data(), values, nullptr);
  if (status != BCCSPLAT_ERROR_OUT_OF_DOMAIN && status != BCCSPLAT_ERROR_HOLE) check(status); // they are NaN
}

} // namespace

extern "C" {

// Fills a plane, `width` x `height` values along the two other axes, x fastest; axis 0 .. 2 is constant, at a
// fraction of the domain.
EMSCRIPTEN_KEEPALIVE int web_plane(int axis, double at, int width, int height, float* values) {
  return answer([&] {
    Place from{}, to{1, 1, 1};
    std::array<int, 3> counts{width, height, height};
    if (axis == 0) counts[1] = width;
    const auto a = static_cast<size_t>(axis);
    from[a] = to[a] = at, counts[a] = 1;
    sample(from, to, counts, values);
  });
}

// The value at fractions of the domain; NaN where there is none.
EMSCRIPTEN_KEEPALIVE double web_value(double x, double y, double z) {
  float value = std::numeric_limits<float>::quiet_NaN();
  (void)answer([&] { sample({x, y, z}, {x, y, z}, {1, 1, 1}, &value); });
  return static_cast<double>(value);
}

} // extern "C"
