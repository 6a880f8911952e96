// SPDX-License-Identifier: Apache-2.0
// Which samples of a source frame are missing, as a run list (bcc4.md, record 10).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "points/mask_source.h"

namespace bccsplat {

// Writes the list run by run.
class MaskRunWriter {
 public:
  // Voxels begin .. end - 1 are missing; runs rise, and those that touch become one.
  void add(uint64_t begin, uint64_t end);
  // The list; empty when nothing is missing.
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  void write_run();

  ByteWriter out_;
  uint64_t written_ = 0; // voxels the list covers so far
  uint64_t begin_ = 0, end_ = 0;
};

// Calls body for each run of missing voxels, of `voxels` in a frame. `offset` of the block is for error
// texts. Throws corrupt, truncated.
void read_mask_runs(std::span<const std::byte> decoded, uint64_t voxels, uint64_t offset,
                    const MaskRunBody& body);

} // namespace bccsplat
