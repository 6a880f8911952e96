// SPDX-License-Identifier: Apache-2.0
// What is known of each of the last finished sheets of a tile.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace bccsplat {

// Four sheets are looked at together, and their gradients look at two more on either side; pixels are raised
// from as many sheets of the ring at most. A power of two.
inline constexpr size_t finished_sheets = 8;

[[nodiscard]] constexpr size_t finished_slot(int64_t sheet) {
  return static_cast<size_t>(sheet) & (finished_sheets - 1);
}

// A sheet takes the place of the one that is finished_sheets before it.
template<class T> struct FinishedSheets {
  std::array<T, finished_sheets> slot{};

  [[nodiscard]] T& operator[](int64_t sheet) { return slot[finished_slot(sheet)]; }
  [[nodiscard]] const T& operator[](int64_t sheet) const { return slot[finished_slot(sheet)]; }
};

} // namespace bccsplat
