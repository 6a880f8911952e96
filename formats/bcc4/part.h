// SPDX-License-Identifier: Apache-2.0
// What a part of a series knows beyond a whole file: several processes write one series, each a part, and the
// parts are joined without coding anything again (bcc4.md, section 11).
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include "base/bytes.h"
#include "points/series_block.h"

namespace bccsplat {

// One thing that a writer put into its file: the chunks of a slab, or the corrections or the mask of a frame.
// Sorted, those of all parts have the order in which one writer of the whole series writes them.
struct PartWrite {
  static constexpr int64_t chunks = -1;
  static constexpr int32_t mask = -1; // in place of a slab: before those that the frame completes
  uint32_t trigger = 0; // the frame with which it was complete; the number of frames: at the end
  uint32_t channel = 0;
  int32_t slab = 0;       // the slab itself, or the one that completed what the corrections depend on
  int64_t frame = chunks; // of the corrections, or of the mask
  int level = 0;          // of chunks
  // Orders by trigger and channel; masks first, coarse levels before finer ones; by slab and frame.
  bool operator<(const PartWrite& other) const { return order() < other.order(); }
  bool operator==(const PartWrite&) const = default;

 private:
  [[nodiscard]] std::tuple<uint32_t, uint32_t, int, int32_t, int64_t> order() const {
    return {trigger, channel, slab == mask ? INT32_MIN : -level, slab, frame};
  }
};

struct PartInfo {
  SeriesBlock block;   // source samples; ends in space are to_the_end, or of a block all ends are said
  uint32_t series = 0; // checksum of what decides the samples, the same for all parts of a series
  std::vector<PartWrite> writes;
  // What is summed over frames and slabs; private to one version of the library.
  std::vector<std::byte> statistics;
  bool operator==(const PartInfo&) const = default;
};

void write_part(ByteWriter& out, const PartInfo& part);
// `frames`, `channels` and `levels` (0 among them) are those of the series. Throws corrupt, truncated.
[[nodiscard]] PartInfo read_part(ByteReader& in, uint32_t frames, size_t channels, int levels);
// The same of a block, behind its box in space.
void write_block(ByteWriter& out, const PartInfo& part);
[[nodiscard]] PartInfo read_block(ByteReader& in, const std::array<uint32_t, 4>& dims, size_t channels,
                                  int levels);

} // namespace bccsplat
