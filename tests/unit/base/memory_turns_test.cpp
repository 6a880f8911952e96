// SPDX-License-Identifier: Apache-2.0
#include "base/memory_turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/unit/base/bench.h"

namespace bccsplat {
namespace {

TEST(MemoryTurns, AsManyAtOnceAsThereIsRoomFor) {
  test::Bench bench(8, 250);
  MemoryTurns turns(bench.memory);
  std::atomic<int> now{0}, most{0}, done{0};
  bench.tasks.parallel_for(40, [&](uint64_t) {
    turns.run(100, "work", [&] {
      const int at_work = ++now;
      for (int seen = most; seen < at_work && !most.compare_exchange_weak(seen, at_work);) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      --now, ++done;
    });
  });
  EXPECT_EQ(done, 40);
  EXPECT_LE(most, 2);
  EXPECT_GE(bench.memory.peak(), 100u);
  EXPECT_EQ(bench.memory.used(), 0u);
}

TEST(MemoryTurns, WhoIsAloneAndFindsNoRoomFails) {
  test::Bench bench(2, 99);
  MemoryTurns turns(bench.memory);
  try {
    turns.run(100, "work", [] { ADD_FAILURE() << "done without room"; });
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::memory_budget);
  }
  // Work that fails gives its bytes back, and the next one has its turn.
  EXPECT_THROW(turns.run(99, "work", []() -> int { fail(Code::corrupt, "damaged"); }), Error);
  EXPECT_EQ(turns.run(99, "work", [] { return 7; }), 7);
  EXPECT_EQ(bench.memory.used(), 0u);
}

} // namespace
} // namespace bccsplat
