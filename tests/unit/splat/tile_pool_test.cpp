// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/tile_pool.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

TEST(TilePool, FailsWhenThereIsNothingToWaitFor) {
  MemoryBudget budget(1000);
  {
    TilePool pool(budget);
    EXPECT_THROW((void)pool.take(1001), Error);
    auto held = pool.take(1000);
    EXPECT_EQ(budget.used(), 1000u);
    pool.give_back(std::move(held)); // it holds nothing
    EXPECT_EQ(budget.used(), 0u);
  }
  EXPECT_EQ(budget.used(), 0u);
}

// Eight threads that want 400 of 1000 bytes: all come through, never more than two at once.
TEST(TilePool, WaitsForOthers) {
  MemoryBudget budget(1000);
  TilePool pool(budget);
  std::atomic<int> at_once{0}, most{0}, done{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 50; ++k) {
        auto held = pool.take(400);
        const int now = ++at_once;
        for (int m = most; now > m && !most.compare_exchange_weak(m, now);) {
        }
        std::this_thread::yield();
        --at_once;
        pool.give_back(std::move(held));
        ++done;
      }
    });
  for (auto& t : threads) t.join();
  EXPECT_EQ(done, 400);
  EXPECT_LE(most, 2);
  EXPECT_LE(budget.peak(), 1000u);
}

// What a tile grew to beyond what was reserved is reserved while it is kept, and given back with it.
TEST(TilePool, CountsWhatATileHolds) {
  MemoryBudget budget(10000);
  {
    TilePool pool(budget);
    auto held = pool.take(100);
    held->memory.pixels.reserve(1000);
    pool.give_back(std::move(held));
    EXPECT_EQ(budget.used(), 4000u);
    held = pool.take(8000); // the idle one's bytes count among them
    EXPECT_EQ(budget.used(), 8000u);
    held->memory.rays.reserve(4000); // more than there is: not kept
    pool.give_back(std::move(held));
    EXPECT_EQ(budget.used(), 0u);
  }
  EXPECT_EQ(budget.used(), 0u);
}

} // namespace
} // namespace bccsplat
