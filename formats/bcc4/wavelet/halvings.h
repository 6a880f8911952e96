// SPDX-License-Identifier: Apache-2.0
// A box that is halved again and again along its axes by lifting: predict and update steps, in place.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace bccsplat {

inline constexpr int most_halved = 5; // times that an axis is

// Samples of a box along x, y, z, and how often each axis is halved.
struct Halvings {
  std::array<int, 3> size{1, 1, 1}, times{0, 0, 0};
  [[nodiscard]] int levels() const;
  // Samples along an axis that are left after so many levels.
  [[nodiscard]] int kept(int axis, int level) const;
  [[nodiscard]] bool halves(int axis, int level) const { return times[axis] >= level; }
  [[nodiscard]] size_t samples() const { return size_t(size[0]) * size[1] * size[2]; }
};

// A frame, x fastest, to its coefficients: along each axis the coarse half comes first. The steps are those
// of the biorthogonal wavelets 9/7, scaled so that the squares of errors nearly add up.
void analyse(const Halvings& shape, std::span<float> frame);
void synthesise(const Halvings& shape, std::span<float> frame);

// Samples along each axis, from first to before end.
struct BoxPart {
  std::array<int, 3> first{0, 0, 0}, end{0, 0, 0};
};
// Makes the samples of a part, to the bit as of the whole; what stands in the rest of the frame then means
// nothing.
void synthesise(const Halvings& shape, const BoxPart& part, std::span<float> frame);

} // namespace bccsplat
