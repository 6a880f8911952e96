// SPDX-License-Identifier: Apache-2.0
// The chain of the trial coder: axis by axis, predict and update steps, in place.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace bccsplat::bench {

// How often each axis of a frame is halved, and its samples: x, y, z.
struct Chain {
  std::array<int, 3> size{1, 1, 1}, halvings{0, 0, 0};
  [[nodiscard]] int levels() const;
  // Samples along an axis that are left after so many levels.
  [[nodiscard]] int kept(int axis, int level) const;
  [[nodiscard]] bool halves(int axis, int level) const { return halvings[axis] >= level; }
  [[nodiscard]] size_t samples() const { return size_t(size[0]) * size[1] * size[2]; }
};

// A frame, x fastest, to its coefficients: along each axis the coarse half comes first. The steps are those
// of the biorthogonal wavelets 9/7, scaled so that the squares of errors nearly add up.
void analyse(const Chain& chain, std::span<float> frame);
void synthesise(const Chain& chain, std::span<float> frame);

} // namespace bccsplat::bench
