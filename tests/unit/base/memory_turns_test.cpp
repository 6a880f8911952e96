// SPDX-License-Identifier: Apache-2.0
#include "base/memory_turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/unit/base/bench.h"

namespace bccsplat {
namespace {

// Returns how many of 40 pieces of work were under way at once at most; run(work) does one.
template<class Run> int most_at_once(test::Bench& bench, const Run& run) {
  std::atomic<int> now{0}, most{0}, done{0};
  bench.tasks.parallel_for(40, [&](uint64_t) {
    run([&] {
      const int at_work = ++now;
      for (int seen = most; seen < at_work && !most.compare_exchange_weak(seen, at_work);) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      --now, ++done;
    });
  });
  EXPECT_EQ(done, 40);
  EXPECT_EQ(bench.memory.used(), 0u);
  return most;
}

TEST(MemoryTurns, AsManyAtOnceAsThereIsRoomFor) {
  test::Bench bench(8, 250);
  MemoryTurns turns(bench.memory);
  EXPECT_LE(most_at_once(bench, [&](const auto& work) { turns.run(100, "work", work); }), 2);
  EXPECT_GE(bench.memory.peak(), 100u);
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

TEST(MemoryTurns, OneGoesOnBesideTheBudget) {
  for (const uint64_t room : {99u, 250u}) {
    test::Bench bench(8, room);
    MemoryTurns turns(bench.memory);
    const int most = most_at_once(bench, [&](const auto& work) { turns.run_one_beside(100, work); });
    EXPECT_LE(most, room < 100 ? 1 : 2);
  }
}

} // namespace
} // namespace bccsplat
