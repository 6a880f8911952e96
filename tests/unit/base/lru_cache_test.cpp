// SPDX-License-Identifier: Apache-2.0
#include "base/lru_cache.h"

#include <gtest/gtest.h>

#include <memory>

namespace bccsplat {
namespace {

using Cache = LruCache<int, int>;

void put(Cache& cache, int key, uint64_t weight, std::shared_ptr<int> hold = nullptr) {
  cache.insert(key, std::make_shared<const int>(10 * key), weight, std::move(hold));
}

TEST(LruCache, TakesOverTheNewestThatFitAndAreWanted) {
  Cache older(100), newer(25);
  for (int key = 1; key <= 6; ++key) put(older, key, 10);
  put(newer, 9, 3);
  (void)older.find(2); // from the oldest to the newest: 1 3 4 5 6 2
  newer.take_over(older, [](int key) { return key != 6; });
  for (int key = 1; key <= 6; ++key) EXPECT_EQ(newer.contains(key), key == 2 || key == 5) << key;
  EXPECT_EQ(newer.look(5), older.look(5)) << "the value itself is shared";
  // What was there stays the newest, and what was taken goes in its old order.
  EXPECT_TRUE(newer.drop_oldest());
  EXPECT_FALSE(newer.contains(5));
  EXPECT_TRUE(newer.drop_oldest());
  EXPECT_FALSE(newer.contains(2));
  EXPECT_TRUE(newer.contains(9));
  put(newer, 7, 22); // the weights were counted
  EXPECT_TRUE(newer.contains(7) && newer.contains(9));
}

TEST(LruCache, WhatIsHeldStaysUntilNobodyHasTheEntry) {
  const auto hold = std::make_shared<int>(1);
  auto older = std::make_unique<Cache>(100);
  Cache newer(100);
  put(*older, 1, 10, hold);
  EXPECT_EQ(hold.use_count(), 2);
  newer.take_over(*older, [](int) { return true; });
  EXPECT_EQ(hold.use_count(), 2) << "once, not twice";
  older.reset();
  EXPECT_EQ(hold.use_count(), 2);
  newer.drop(1);
  EXPECT_EQ(hold.use_count(), 1);
}

} // namespace
} // namespace bccsplat
