// SPDX-License-Identifier: Apache-2.0
#include "base/memory.h"

#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

TEST(MemoryBudget, GivesToTheLimitAndNotBeyond) {
  MemoryBudget budget(100);
  EXPECT_TRUE(budget.try_reserve(60));
  EXPECT_FALSE(budget.try_reserve(41));
  EXPECT_FALSE(budget.try_reserve(UINT64_MAX));
  EXPECT_TRUE(budget.try_reserve(40));
  EXPECT_FALSE(budget.try_reserve(1));
  budget.release(100);
  EXPECT_EQ(budget.used(), 0u);
  EXPECT_EQ(budget.peak(), 100u);
}

TEST(MemoryBudget, ReservationsReturnTheirBytesOnce) {
  MemoryBudget budget(100);
  {
    Reservation a(budget, 30, "a");
    std::optional<Reservation> b(std::move(a));
    EXPECT_EQ(budget.used(), 30u);
    Reservation c(budget, 50, "c");
    c = std::move(*b);
    b.reset();
    EXPECT_EQ(budget.used(), 30u);
    EXPECT_EQ(c.bytes(), 30u);
    try {
      const Reservation d(budget, 71, "the d");
      ADD_FAILURE() << "71 of 70 bytes were given";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::memory_budget);
      EXPECT_NE(e.message().find("the d"), std::string::npos);
    }
  }
  EXPECT_EQ(budget.used(), 0u);
}

TEST(MemoryBudget, ThreadsAddToOneReservation) {
  MemoryBudget budget(1000);
  Reservation held;
  {
    SharedReservation shared(budget);
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&shared] {
        for (int i = 0; i < 50; ++i) shared.add(3, "bricks");
      });
    threads.clear();
    EXPECT_EQ(budget.used(), 600u);
    held = shared.take();
  }
  EXPECT_EQ(held.bytes(), 600u);
  EXPECT_EQ(budget.used(), 600u);
  {
    SharedReservation shared(budget);
    shared.add(300, "bricks");
    EXPECT_THROW(shared.add(300, "bricks"), Error);
  } // what was not taken is given back
  EXPECT_EQ(budget.used(), 600u);
}

TEST(MemoryBudget, ThreadsTogetherNeverPassTheLimit) {
  MemoryBudget budget(10);
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&budget] {
      for (int i = 0; i < 20000; ++i)
        if (budget.try_reserve(3)) budget.release(3);
    });
  threads.clear();
  EXPECT_EQ(budget.used(), 0u);
  EXPECT_LE(budget.peak(), 9u);
}

} // namespace
} // namespace bccsplat
