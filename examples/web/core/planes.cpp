// SPDX-License-Identifier: Apache-2.0
// Values on the x, y and z plane through a point of the moment that is drawn.
#include <emscripten.h>

#include <algorithm>
#include <array>
#include <limits>

#include "viewer.h"

using namespace web;

namespace {

// Samples a plane of constant `axis`, `width` x `height` values along the two other axes, x fastest.
void sample_plane(const bccsplat_slice_info& info, int axis, double at, int width, int height,
                  float* values) {
  auto grid = sized<bccsplat_grid>();
  const std::array<int, 2> across = axis == 0   ? std::array{1, 2}
                                    : axis == 1 ? std::array{0, 2}
                                                : std::array{0, 1};
  for (int a = 0; a < 3; ++a) grid.dims[a] = 1, grid.step[a] = 1;
  grid.origin[axis] = info.extent[axis][0] + at * (info.extent[axis][1] - info.extent[axis][0]);
  const std::array<int, 2> counts{width, height};
  for (size_t i = 0; i < 2; ++i) {
    const int a = across[i], count = counts[i];
    grid.dims[a] = static_cast<uint64_t>(count);
    grid.origin[a] = info.extent[a][0];
    grid.step[a] = (info.extent[a][1] - info.extent[a][0]) / std::max(count - 1, 1);
    if (grid.step[a] <= 0) grid.step[a] = 1;
  }
  check(bccsplat_slice_sample_grid(viewer.moment.slice.get(), &grid, values));
}

} // namespace

extern "C" {

// Fills a plane; axis 0 .. 2 is constant, at a fraction of the domain.
EMSCRIPTEN_KEEPALIVE int web_plane(int axis, double at, int width, int height, float* values) {
  return answer([&] {
    auto info = sized<bccsplat_slice_info>();
    check(bccsplat_slice_get_info(viewer.moment.slice.get(), &info));
    sample_plane(info, axis, at, width, height, values);
  });
}

// The value at fractions of the domain; NaN where there is none.
EMSCRIPTEN_KEEPALIVE double web_value(double x, double y, double z) {
  const std::array<double, 3> at{x, y, z};
  double value = std::numeric_limits<double>::quiet_NaN();
  (void)answer([&] {
    auto info = sized<bccsplat_slice_info>();
    check(bccsplat_slice_get_info(viewer.moment.slice.get(), &info));
    std::array<double, 3> uvw{};
    for (size_t a = 0; a < 3; ++a)
      uvw[a] = info.extent[a][0] + at[a] * (info.extent[a][1] - info.extent[a][0]);
    float found = 0;
    check(bccsplat_slice_evaluate(viewer.moment.slice.get(), 1, uvw.data(), &found, nullptr));
    value = static_cast<double>(found);
  });
  return value;
}

} // extern "C"
