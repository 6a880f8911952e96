// SPDX-License-Identifier: Apache-2.0
// Places in planes: pixels, samples and sites that lie row by row in memory, the rows `pitch` values apart.
#pragma once

#include <cstddef>

namespace bccsplat {

// Returns the index of column x of row y, neither of them negative.
[[nodiscard]] constexpr size_t plane_index(int x, int y, int pitch) {
  return static_cast<size_t>(y) * pitch + x;
}

// Returns the distance of column x of row y from the first value. Planes with a border have values at
// negative x and y, too.
[[nodiscard]] constexpr std::ptrdiff_t plane_offset(int x, int y, int pitch) {
  return static_cast<std::ptrdiff_t>(y) * pitch + x;
}

// Returns how many values `rows` rows are.
[[nodiscard]] constexpr size_t plane_size(int pitch, int rows) { return static_cast<size_t>(pitch) * rows; }

} // namespace bccsplat
