// SPDX-License-Identifier: Apache-2.0
// Ranges of bytes in a file.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace bccsplat {

struct ByteRange {
  uint64_t offset = 0, size = 0;
  bool operator==(const ByteRange&) const = default;
};

// Sorts ranges and makes one of those that overlap or have at most `gap` bytes between them. None reaches
// beyond 2^64; empty ones are left out.
inline void merge_ranges(std::vector<ByteRange>& ranges, uint64_t gap) {
  std::erase_if(ranges, [](const ByteRange& r) { return r.size == 0; });
  std::sort(ranges.begin(), ranges.end(),
            [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  size_t count = 0;
  for (const ByteRange& r : ranges) {
    ByteRange* const last = count > 0 ? &ranges[count - 1] : nullptr;
    if (last && (r.offset <= last->offset + last->size || r.offset - last->offset - last->size <= gap))
      last->size = std::max(last->size, r.offset + r.size - last->offset);
    else
      ranges[count++] = r;
  }
  ranges.resize(count);
}

} // namespace bccsplat
