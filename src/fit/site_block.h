// Blocks of lattice samples between the stages of a fit, drawn from the memory budget and used again.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "base/memory.h"
#include "points/brick.h"

namespace bccsplat {

// One frame on the sites of one brick; undefined beyond the dims of its coset.
struct SiteBlock {
  alignas(64) std::array<float, brick_sites> value; // (z*16 + y)*16 + x, relative to air
  BrickMask source;                                 // sites whose nearest source sample is not air
  float largest;                                    // no source sample in reach is further from air
};
using SiteBlockPtr = std::shared_ptr<SiteBlock>;

// One frame on the sites of both cosets, by brick slot.
struct FrameSites {
  std::array<std::vector<SiteBlockPtr>, 2> block;               // null: air
  std::array<std::vector<std::unique_ptr<BrickMask>>, 2> holes; // null: none; empty: none at all
};

// Hands out blocks from any thread. Blocks must go before the pool and its budget.
class SiteBlockPool {
 public:
  explicit SiteBlockPool(MemoryBudget& memory) : memory_(memory) {}
  ~SiteBlockPool() { memory_.release(sizeof(SiteBlock) * free_.size()); }
  SiteBlockPool(const SiteBlockPool&) = delete;
  SiteBlockPool& operator=(const SiteBlockPool&) = delete;

  [[nodiscard]] SiteBlockPtr take() {
    std::unique_ptr<SiteBlock> block;
    {
      const std::scoped_lock lock(mutex_);
      if (!free_.empty()) {
        block = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!block) {
      if (!memory_.try_reserve(sizeof(SiteBlock)))
        fail(Code::memory_budget,
             "the frames within reach of the resampling filter do not fit the memory budget of ",
             memory_.limit(), " bytes; raise it or use a shorter filter");
      Reservation held =
          Reservation::adopt(memory_, sizeof(SiteBlock)); // until the block is one of the pool's
      block.reset(new SiteBlock);
      const std::scoped_lock lock(mutex_);
      free_.reserve(made_ + 1); // giving a block back must not fail
      ++made_;
      held.keep();
    }
    return {block.release(), [this](SiteBlock* b) { give_back(std::unique_ptr<SiteBlock>(b)); }};
  }

 private:
  void give_back(std::unique_ptr<SiteBlock> block) {
    const std::scoped_lock lock(mutex_);
    free_.push_back(std::move(block));
  }

  MemoryBudget& memory_;
  std::mutex mutex_;
  size_t made_ = 0; // blocks, free or in use
  std::vector<std::unique_ptr<SiteBlock>> free_;
};

} // namespace bccsplat
