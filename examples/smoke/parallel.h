// SPDX-License-Identifier: Apache-2.0
// Spreads the parts of an index range over threads; what is computed must not depend on how the range was
// cut.
#pragma once

#include <algorithm>
#include <thread>
#include <vector>

namespace smoke {

// Calls body(begin, end) on `threads` disjoint ranges that cover [0, count).
template<class Body> void parallel_ranges(int threads, int count, const Body& body) {
  const int parts = std::clamp(threads, 1, std::max(count, 1));
  std::vector<std::jthread> others;
  for (int part = 1; part < parts; ++part)
    others.emplace_back(
        [&body, part, parts, count] { body(count * part / parts, count * (part + 1) / parts); });
  body(0, count / parts);
}

} // namespace smoke
