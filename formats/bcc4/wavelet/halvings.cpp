// SPDX-License-Identifier: Apache-2.0
// Goes through the levels and axes of a box.
#include "formats/bcc4/wavelet/halvings.h"

#include <algorithm>
#include <vector>

#include "formats/bcc4/wavelet/lift.h"

namespace bccsplat {
namespace {

// Places along an axis, from first to before end.
struct Stretch {
  int first = 0, end = 0;
  [[nodiscard]] int count() const { return end - first; }
};
// By axis, of a coarse half alone, or of both halves.
using Stretches = std::array<std::vector<Stretch>, 3>;

// The coarse coefficients, of so many, that some samples are made of. The fine ones are the same places of
// the other half.
Stretch coarse_of(const Stretch& samples, int coarse) {
  constexpr int reach = 4; // samples to each side, one for each lifting step
  return {std::max(samples.first - reach, 0) / 2, std::min((samples.end - 1 + reach) / 2 + 1, coarse)};
}

// Lifts whole lines along an axis, those at these places of the other two.
void transform_lines(const Halvings& shape, int level, int axis, const Stretches& lines, bool inverse,
                     float* frame, std::vector<float>& scratch) {
  const int count = shape.kept(axis, level - 1);
  const size_t row = shape.size[0], plane = row * shape.size[1];
  const auto each = [](const std::vector<Stretch>& stretches, const auto& body) {
    for (const Stretch& s : stretches)
      for (int i = s.first; i < s.end; ++i) body(i);
  };
  if (axis == 0)
    each(lines[2], [&](int z) {
      for (const Stretch& y : lines[1])
        lift_along({frame + z * plane + y.first * row, row, count, y.count()}, inverse, scratch);
    });
  else
    each(lines[3 - axis], [&](int other) {
      float* const first = frame + other * (axis == 1 ? plane : row);
      for (const Stretch& x : lines[0])
        lift_across({first + x.first, axis == 1 ? row : plane, count, x.count()}, inverse, scratch);
    });
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
  for (int level = 1; level <= shape.levels(); ++level) {
    Stretches all;
    for (int axis = 0; axis < 3; ++axis) all[axis] = {{0, shape.kept(axis, level - 1)}};
    for (int axis = 0; axis < 3; ++axis)
      if (is_split(shape, level, axis))
        transform_lines(shape, level, axis, all, false, frame.data(), scratch);
  }
}

void synthesise(const Halvings& shape, std::span<float> frame) {
  synthesise(shape, {{0, 0, 0}, shape.size}, frame);
}

void synthesise(const Halvings& shape, const BoxPart& part, std::span<float> frame) {
  // What each level has to make, the finest first.
  std::vector<std::array<Stretch, 3>> made(shape.levels() + 1);
  for (int axis = 0; axis < 3; ++axis) made[0][axis] = {part.first[axis], part.end[axis]};
  for (int level = 1; level <= shape.levels(); ++level)
    for (int axis = 0; axis < 3; ++axis) {
      const Stretch& below = made[level - 1][axis];
      made[level][axis] = is_split(shape, level, axis) ? coarse_of(below, shape.kept(axis, level)) : below;
    }
  std::vector<float> scratch;
  for (int level = shape.levels(); level >= 1; --level) {
    Stretches lines;
    for (int axis = 0; axis < 3; ++axis) {
      lines[axis] = {made[level][axis]};
      if (!is_split(shape, level, axis)) continue;
      const int coarse = shape.kept(axis, level), all = shape.kept(axis, level - 1);
      const Stretch& half = made[level][axis];
      lines[axis].push_back({coarse + half.first, std::min(coarse + half.end, all)});
    }
    for (int axis = 2; axis >= 0; --axis) {
      if (!is_split(shape, level, axis)) continue;
      transform_lines(shape, level, axis, lines, true, frame.data(), scratch);
      lines[axis] = {made[level - 1][axis]};
    }
  }
}

} // namespace bccsplat
