// SPDX-License-Identifier: Apache-2.0
// Goes through the levels and axes of a box.
#include "formats/bcc4/wavelet/halvings.h"

#include <algorithm>
#include <vector>

#include "formats/bcc4/wavelet/lift.h"

namespace bccsplat {
namespace {

void transform_axis(const Halvings& shape, int level, int axis, bool inverse, float* frame,
                    std::vector<float>& scratch) {
  const int nx = shape.kept(0, level - 1), ny = shape.kept(1, level - 1), nz = shape.kept(2, level - 1);
  const size_t row = shape.size[0], plane = row * shape.size[1];
  if (axis == 0)
    for (int z = 0; z < nz; ++z) lift_along({frame + z * plane, row, nx, ny}, inverse, scratch);
  if (axis == 1)
    for (int z = 0; z < nz; ++z) lift_across({frame + z * plane, row, ny, nx}, inverse, scratch);
  if (axis == 2)
    for (int y = 0; y < ny; ++y) lift_across({frame + y * row, plane, nz, nx}, inverse, scratch);
}

bool is_split(const Halvings& shape, int level, int axis) {
  return shape.halves(axis, level) && shape.kept(axis, level - 1) > 1;
}

} // namespace

int Halvings::levels() const { return std::max({times[0], times[1], times[2]}); }

int Halvings::kept(int axis, int level) const {
  const int by = std::min(level, times[axis]);
  return (size[axis] + (1 << by) - 1) >> by;
}

void analyse(const Halvings& shape, std::span<float> frame) {
  std::vector<float> scratch;
  for (int level = 1; level <= shape.levels(); ++level)
    for (int axis = 0; axis < 3; ++axis)
      if (is_split(shape, level, axis)) transform_axis(shape, level, axis, false, frame.data(), scratch);
}

void synthesise(const Halvings& shape, std::span<float> frame) {
  std::vector<float> scratch;
  for (int level = shape.levels(); level >= 1; --level)
    for (int axis = 2; axis >= 0; --axis)
      if (is_split(shape, level, axis)) transform_axis(shape, level, axis, true, frame.data(), scratch);
}

} // namespace bccsplat
