// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/write/mask_blocks.h"

#include <algorithm>

namespace bccsplat {
namespace {

constexpr uint64_t most_held = 4 << 20; // bytes; the last block is held whatever its size

} // namespace

std::optional<BlockRef> MaskBlocks::find(const PackedBlock& block) const {
  const auto same = std::find_if(recent_.rbegin(), recent_.rend(), [&](const PackedBlock& b) {
    return b.ref.coding == block.ref.coding && b.ref.stored == block.ref.stored && b.bytes == block.bytes;
  });
  return same == recent_.rend() ? std::nullopt : std::optional(same->ref);
}

void MaskBlocks::add(PackedBlock block) {
  held_ += block.bytes.size();
  recent_.push_back(std::move(block));
  for (; held_ > most_held && recent_.size() > 1; recent_.pop_front()) held_ -= recent_.front().bytes.size();
}

} // namespace bccsplat
