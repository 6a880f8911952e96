// SPDX-License-Identifier: Apache-2.0
// A rectangle of a plane outside which all is 0.
#pragma once

#include <algorithm>

namespace bccsplat {

// Sites first .. end - 1 along x and y; empty where an end is not behind its first.
struct FilledBox {
  int first_x = 0, end_x = 0, first_y = 0, end_y = 0;

  [[nodiscard]] bool empty() const { return first_x >= end_x || first_y >= end_y; }
  // Makes it hold the other one as well.
  void add(const FilledBox& other) {
    if (other.empty()) return;
    if (empty()) {
      *this = other;
      return;
    }
    first_x = std::min(first_x, other.first_x), end_x = std::max(end_x, other.end_x);
    first_y = std::min(first_y, other.first_y), end_y = std::max(end_y, other.end_y);
  }
  // Returns the box of the sites that see one of it, each seeing `from` to `to` beside it along both axes.
  [[nodiscard]] FilledBox seen(int from, int to) const {
    if (empty()) return {};
    return {first_x - to, end_x - from, first_y - to, end_y - from};
  }
  [[nodiscard]] FilledBox within(const FilledBox& other) const {
    return {std::max(first_x, other.first_x), std::min(end_x, other.end_x), std::max(first_y, other.first_y),
            std::min(end_y, other.end_y)};
  }
  [[nodiscard]] bool meets(const FilledBox& other) const { return !within(other).empty(); }
};

} // namespace bccsplat
