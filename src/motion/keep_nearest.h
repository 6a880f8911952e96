// SPDX-License-Identifier: Apache-2.0
// What is kept by frame or interval: the nearest ones.
#pragma once

#include <cstddef>
#include <iterator>

namespace bccsplat::motion {

// Erases the keys furthest from i until so many are left.
template<class Map> void keep_nearest(Map& map, size_t i, size_t count) {
  const auto away = [i](size_t key) { return key > i ? key - i : i - key; };
  while (map.size() > count) {
    const auto first = map.begin(), last = std::prev(map.end());
    map.erase(away(first->first) > away(last->first) ? first : last);
  }
}

} // namespace bccsplat::motion
