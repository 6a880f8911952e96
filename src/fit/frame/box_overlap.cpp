// SPDX-License-Identifier: Apache-2.0
#include "fit/frame/box_overlap.h"

#include <algorithm>
#include <vector>

namespace bccsplat {
namespace {

using Pair = std::optional<std::array<size_t, 2>>;
using Numbers = std::vector<size_t>;

constexpr size_t few_boxes = 16; // that are compared each with each

int64_t end_of(const FrameBox& box, size_t axis) { return box.begin[axis] + box.dims[axis]; }

bool overlap(const FrameBox& a, const FrameBox& b) {
  for (size_t axis = 0; axis < 3; ++axis)
    if (a.begin[axis] >= end_of(b, axis) || b.begin[axis] >= end_of(a, axis)) return false;
  return true;
}

Pair compare_all(std::span<const FrameBox> boxes, const Numbers& list) {
  for (size_t j = 1; j < list.size(); ++j)
    for (size_t i = 0; i < j; ++i)
      if (overlap(boxes[list[i]], boxes[list[j]])) return {{list[i], list[j]}};
  return std::nullopt;
}

// The boxes before a plane and behind it; those that it cuts are on both sides.
struct Cut {
  size_t axis = 0;
  int64_t at = 0;
  size_t before = 0, behind = 0;
  [[nodiscard]] size_t larger() const { return std::max(before, behind); }
};

// Cuts where half of the boxes have begun.
Cut cut_along(std::span<const FrameBox> boxes, const Numbers& list, size_t axis) {
  std::vector<int64_t> begins;
  for (const size_t n : list) begins.push_back(boxes[n].begin[axis]);
  const auto middle = begins.begin() + begins.size() / 2;
  std::nth_element(begins.begin(), middle, begins.end());
  Cut cut{axis, *middle};
  for (const size_t n : list) {
    cut.before += boxes[n].begin[axis] < cut.at;
    cut.behind += end_of(boxes[n], axis) > cut.at;
  }
  return cut;
}

// `list` rises.
Pair search(std::span<const FrameBox> boxes, const Numbers& list) {
  if (list.size() <= few_boxes) return compare_all(boxes, list);
  Cut best = cut_along(boxes, list, 0);
  for (size_t axis = 1; axis < 3; ++axis)
    if (const Cut cut = cut_along(boxes, list, axis); cut.larger() < best.larger()) best = cut;
  if (best.larger() == list.size()) return compare_all(boxes, list);
  Numbers before, behind;
  for (const size_t n : list) {
    if (boxes[n].begin[best.axis] < best.at) before.push_back(n);
    if (end_of(boxes[n], best.axis) > best.at) behind.push_back(n);
  }
  if (const Pair found = search(boxes, before)) return found;
  return search(boxes, behind);
}

} // namespace

std::optional<std::array<size_t, 2>> find_overlap(std::span<const FrameBox> boxes) {
  Numbers all(boxes.size());
  for (size_t n = 0; n < all.size(); ++n) all[n] = n;
  return search(boxes, all);
}

} // namespace bccsplat
