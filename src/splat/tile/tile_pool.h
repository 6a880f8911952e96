// SPDX-License-Identifier: Apache-2.0
// The memory of the tiles of several objects, within the budget: as many tiles are drawn at once as fit it.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "base/memory.h"
#include "splat/tile/tile.h"

namespace bccsplat {

// Returns about how many bytes drawing tile `n` takes.
[[nodiscard]] uint64_t tile_bytes(const TileJob& job, size_t n);

class TilePool {
 public:
  explicit TilePool(MemoryBudget& budget) : budget_(budget) {}
  TilePool(const TilePool&) = delete;
  TilePool& operator=(const TilePool&) = delete;
  ~TilePool() { drop_idle(); }

  // A tile's memory; `bytes` are reserved as long as it is kept.
  struct Held {
    TileMemory memory;
    uint64_t reserved = 0;
  };
  // Waits for other tiles to end until `bytes` are to be had; fails when there is none to wait for. Any
  // thread may call it.
  [[nodiscard]] std::unique_ptr<Held> take(uint64_t bytes);
  // Every memory that was taken must come back. Throws nothing.
  void give_back(std::unique_ptr<Held> held);

 private:
  void drop(std::unique_ptr<Held> held);
  void drop_idle();

  MemoryBudget& budget_;
  std::mutex mutex_;
  std::condition_variable ended_; // a tile
  std::vector<std::unique_ptr<Held>> idle_;
  int taken_ = 0;
};

} // namespace bccsplat
