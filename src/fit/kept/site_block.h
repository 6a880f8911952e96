// SPDX-License-Identifier: Apache-2.0
// Blocks of lattice samples between the stages of a fit, drawn from the memory budget and used again.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <type_traits>
#include <vector>

#include "base/memory.h"
#include "points/brick.h"
#include "points/whole_numbers.h"

namespace bccsplat {

// One frame on the sites of one brick: what is known of them. The values are in one of two forms.
struct SiteBlock {
  BrickMask source; // sites whose nearest source sample is not air
  BrickMask near;   // sites around which one is not (near_source.h)
  float largest;    // no source sample in reach is further from air
  bool packed;      // the form: PackedSites or FloatSites
};
// Values (z*16 + y)*16 + x, relative to air; undefined beyond the dims of the coset.
struct FloatSites : SiteBlock {
  alignas(64) std::array<float, brick_sites> value;
};
// The same as whole numbers, for less than half the memory.
struct PackedSites : SiteBlock {
  NumberForm form;
  uint8_t* number; // of the block itself
};
template<int bits> struct NumberSites : PackedSites {
  alignas(64) std::array<uint8_t, number_bytes(bits)> room;
};
using SiteBlockPtr = std::shared_ptr<const SiteBlock>;
using FloatSitesPtr = std::shared_ptr<FloatSites>;

// Some of the sites of both cosets, by brick slot; null: none, empty: none at all.
using SiteMasks = std::array<std::vector<std::unique_ptr<BrickMask>>, 2>;

// One frame on the sites of both cosets, by brick slot.
struct FrameSites {
  std::array<std::vector<SiteBlockPtr>, 2> block; // null: air
  SiteMasks holes;                                // where it is missing
  bool masked = false; // that is told elsewhere: holes are not marked on the lattice, and
  SiteMasks deep;      // where it is missing far from all data nothing is stored
  // A frame that is missing altogether holds what the last one before it does, and is so far behind that; 0:
  // it is there, or all before it are missing, too.
  int64_t gap = 0;
};

// Blocks of one form, handed out from any thread. Blocks must go before the pool and its budget.
template<class Block> class BlockPool {
 public:
  explicit BlockPool(MemoryBudget& memory) : memory_(memory) {}
  ~BlockPool() { memory_.release(sizeof(Block) * free_.size()); }
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  [[nodiscard]] std::shared_ptr<Block> take() {
    std::unique_ptr<Block> block;
    {
      const std::scoped_lock lock(mutex_);
      if (!free_.empty()) {
        block = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!block) {
      if (!memory_.try_reserve(sizeof(Block)))
        fail(Code::memory_budget,
             "the frames within reach of the resampling filter do not fit the memory budget of ",
             memory_.limit(), " bytes; raise it or use a shorter filter");
      Reservation held = Reservation::adopt(memory_, sizeof(Block)); // until the block is one of the pool's
      block.reset(new Block);
      const std::scoped_lock lock(mutex_);
      free_.reserve(made_ + 1); // giving a block back must not fail
      ++made_;
      held.keep();
    }
    block->packed = std::is_base_of_v<PackedSites, Block>;
    return {block.release(), [this](Block* b) { give_back(std::unique_ptr<Block>(b)); }};
  }

 private:
  void give_back(std::unique_ptr<Block> block) {
    const std::scoped_lock lock(mutex_);
    free_.push_back(std::move(block));
  }

  MemoryBudget& memory_;
  std::mutex mutex_;
  size_t made_ = 0; // blocks, free or in use
  std::vector<std::unique_ptr<Block>> free_;
};

struct SiteBlockPool {
  explicit SiteBlockPool(MemoryBudget& memory) : floats(memory), shorter(memory), longer(memory) {}
  BlockPool<FloatSites> floats;
  BlockPool<NumberSites<12>> shorter;
  BlockPool<NumberSites<16>> longer;
};

} // namespace bccsplat
