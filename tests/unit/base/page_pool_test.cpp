// SPDX-License-Identifier: Apache-2.0
// What a pool hands out, what it keeps for later, and what goes back to the system.
#include "base/page_pool.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <set>
#include <span>
#include <thread>
#include <vector>

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace bccsplat {
namespace {

constexpr size_t block = 17000;
constexpr size_t of_piece = large_page / block;

std::vector<void*> take(PagePool& pool, size_t count, size_t bytes = block) {
  std::vector<void*> blocks;
  for (size_t i = 0; i < count; ++i) {
    blocks.push_back(pool.take());
    std::memset(blocks.back(), static_cast<int>(i % 251), bytes);
  }
  return blocks;
}

void give_back(PagePool& pool, std::span<void* const> blocks) {
  for (void* b : blocks) pool.give_back(b);
}

TEST(PagePool, BlocksAreApartAndBeginOnLines) {
  PageStore store;
  PagePool pool(block, store);
  const std::vector<void*> blocks = take(pool, 3 * of_piece);
  for (size_t i = 0; i < blocks.size(); ++i) {
    EXPECT_EQ(reinterpret_cast<uintptr_t>(blocks[i]) % 64, 0U);
    const auto* const bytes = static_cast<const uint8_t*>(blocks[i]);
    for (const size_t at : {size_t{0}, block / 2, block - 1}) EXPECT_EQ(bytes[at], i % 251) << i;
  }
  give_back(pool, blocks);
}

TEST(PagePool, WhatIsGivenBackIsUsedAgain) {
  PageStore store;
  PagePool pool(block, store);
  std::vector<void*> blocks = take(pool, 2 * of_piece);
  const size_t bytes = store.bytes();
  const std::set<void*> before(blocks.begin(), blocks.end());
  // Some of each piece, then all of them.
  for (const size_t each : {size_t{3}, size_t{1}}) {
    std::vector<void*> left;
    for (size_t i = 0; i < blocks.size(); ++i)
      if (i % each == 0)
        pool.give_back(blocks[i]);
      else
        left.push_back(blocks[i]);
    for (void* b : take(pool, blocks.size() - left.size())) {
      EXPECT_TRUE(before.contains(b));
      left.push_back(b);
    }
    blocks = left;
    EXPECT_EQ(store.bytes(), bytes);
  }
  give_back(pool, blocks);
}

TEST(PagePool, GivesPiecesBackToTheSystem) {
  PageStore store;
  PagePool pool(block, store);
  const std::vector<void*> blocks = take(pool, 20 * of_piece);
  EXPECT_EQ(store.bytes(), 20 * large_page);
  const auto kept = std::span(blocks).first(8 * of_piece), others = std::span(blocks).subspan(8 * of_piece);
  give_back(pool, others);
  EXPECT_EQ(store.bytes(), (8 + 8 / 2) * large_page);
  give_back(pool, kept);
  EXPECT_EQ(store.bytes(), 2 * large_page);
}

TEST(PagePool, PoolsUseWhatOthersGaveBack) {
  PageStore store;
  PagePool large(block, store), small(block / 2, store);
  const std::vector<void*> stay = take(large, 4 * of_piece), go = take(large, 2 * of_piece);
  give_back(large, go);
  const std::vector<void*> smaller = take(small, 4 * of_piece, block / 2);
  EXPECT_EQ(store.bytes(), 6 * large_page);
  give_back(small, smaller);
  give_back(large, stay);
}

TEST(PagePool, ServesThreads) {
  PageStore store;
  PagePool pool(block, store);
  const auto work = [&](uint8_t mark) {
    std::vector<void*> blocks;
    for (size_t i = 0; i < 4 * of_piece; ++i) {
      void* const b = blocks.emplace_back(pool.take());
      std::memset(b, mark, block);
      if (i % 3 != 0) continue;
      EXPECT_EQ(static_cast<const uint8_t*>(blocks[i / 3])[block - 1], mark);
      pool.give_back(blocks[i / 3]);
      blocks[i / 3] = pool.take();
      std::memset(blocks[i / 3], mark, block);
    }
    for (void* b : blocks) {
      EXPECT_EQ(*static_cast<const uint8_t*>(b), mark);
      pool.give_back(b);
    }
  };
  std::vector<std::thread> threads;
  for (uint8_t mark = 1; mark <= 4; ++mark) threads.emplace_back(work, mark);
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(store.bytes(), 2 * large_page);
}

#ifndef _WIN32
// Another thread may be in the middle of a call: without a word to the system the child would wait for ever.
TEST(PagePool, ChildrenOfAForkHaveIt) {
  struct Site {
    std::array<double, 1000> values;
  };
  const std::jthread busy([](const std::stop_token& stop) {
    while (!stop.stop_requested()) (void)make_pooled_for_overwrite<Site>();
  });
  constexpr int children = 50;
  for (int i = 0; i < children; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      alarm(10);
      (void)make_pooled_for_overwrite<Site>();
      _exit(0);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0) << i;
  }
}
#endif

TEST(PagePool, ObjectsOutliveTheirMakers) {
  struct Site {
    std::array<double, 1000> values;
    int made = 1;
  };
  std::vector<std::shared_ptr<Site>> sites;
  for (int i = 0; i < 1000; ++i) sites.push_back(make_pooled_for_overwrite<Site>());
  for (const auto& s : sites) EXPECT_EQ(s->made, 1);
}

} // namespace
} // namespace bccsplat
