// SPDX-License-Identifier: Apache-2.0
// Masks on their way into a file: frames that miss the same samples share a block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "formats/bcc4/layout.h"

namespace bccsplat {

// The blocks written last, as far as they are held: what is shared depends on their order alone, so that all
// ways to one file give the same bytes.
class MaskBlocks {
 public:
  // The block that says the same as `block` (without its offset); none: it is to be written.
  [[nodiscard]] std::optional<BlockRef> find(const PackedBlock& block) const;
  // Holds a block that was written at ref.offset.
  void add(PackedBlock block);

 private:
  std::deque<PackedBlock> recent_; // oldest first
  uint64_t held_ = 0;              // bytes
};

} // namespace bccsplat
