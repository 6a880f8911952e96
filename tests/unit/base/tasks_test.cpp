// SPDX-License-Identifier: Apache-2.0
// Tasks in threads of the library and of a host: each is done once, errors and nested calls included.
#include "base/tasks.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

class TasksOfThreads : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Threads, TasksOfThreads, testing::Values(1, 2, 3, 8));

TEST_P(TasksOfThreads, EachIndexOnce) {
  Tasks tasks(GetParam());
  EXPECT_EQ(tasks.threads(), GetParam());
  for (const uint64_t count : {0, 1, 2, 7, 1000}) {
    std::vector<std::atomic<int>> calls(count);
    tasks.parallel_for(count, [&](uint64_t i) { ++calls.at(i); });
    for (const auto& n : calls) ASSERT_EQ(n, 1);
  }
}

// As many bodies are under way at once as there are threads, the caller's among them.
TEST_P(TasksOfThreads, AllThreadsWorkAtOnce) {
  const int threads = GetParam();
  Tasks tasks(threads);
  std::mutex mutex;
  std::condition_variable all;
  int inside = 0;
  tasks.parallel_for(threads, [&](uint64_t) {
    std::unique_lock lock(mutex);
    ++inside;
    all.notify_all();
    all.wait_for(lock, std::chrono::seconds(60), [&] { return inside == threads; });
    EXPECT_EQ(inside, threads);
  });
}

TEST(TasksOfTheMachine, AreAsManyThreadsAsItHas) {
  EXPECT_EQ(Tasks().threads(), static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  EXPECT_EQ(Tasks(3).threads(), 3);
}

TEST(TasksOfTheMachine, HaveANameForWhoLooksAtTheProcess) {
#ifdef _WIN32
  GTEST_SKIP() << "what Wine shows below /proc is its server";
#endif
  if (!std::ifstream("/proc/thread-self/comm")) GTEST_SKIP() << "no /proc/thread-self";
  Tasks tasks(2);
  const auto caller = std::this_thread::get_id();
  std::mutex mutex;
  std::string name;
  for (int round = 0; round < 1000 && name.empty(); ++round)
    tasks.parallel_for(100, [&](uint64_t) {
      if (std::this_thread::get_id() == caller) {
        std::this_thread::yield();
        return;
      }
      const std::scoped_lock lock(mutex);
      std::ifstream("/proc/thread-self/comm") >> name;
    });
  EXPECT_EQ(name, "bccsplat");
}

TEST_P(TasksOfThreads, WritesAreVisibleAfterwards) {
  Tasks tasks(GetParam());
  std::vector<uint64_t> squares(5000); // plain memory: the thread sanitizer watches the hand-over
  for (int round = 0; round < 20; ++round) {
    tasks.parallel_for(squares.size(), [&](uint64_t i) { squares[i] += i * i; });
    ASSERT_EQ(squares[4999], 4999u * 4999u * static_cast<uint64_t>(round + 1));
  }
}

TEST_P(TasksOfThreads, FirstExceptionArrivesAndThePoolGoesOn) {
  Tasks tasks(GetParam());
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> running{0};
    EXPECT_THROW(tasks.parallel_for(100,
                                    [&](uint64_t i) {
                                      ++running;
                                      if (i == 40) {
                                        --running;
                                        throw std::runtime_error("40");
                                      }
                                      --running;
                                    }),
                 std::runtime_error);
    EXPECT_EQ(running, 0) << "a body still ran when the call returned";
    std::atomic<uint64_t> sum{0};
    tasks.parallel_for(100, [&](uint64_t i) { sum += i; });
    EXPECT_EQ(sum, 4950u);
  }
}

TEST_P(TasksOfThreads, NestedCallsStayInTheirThread) {
  Tasks tasks(GetParam());
  std::atomic<int> inner{0}, elsewhere{0};
  tasks.parallel_for(16, [&](uint64_t) {
    const auto here = std::this_thread::get_id();
    tasks.parallel_for(8, [&](uint64_t) {
      ++inner;
      if (std::this_thread::get_id() != here) ++elsewhere;
    });
  });
  EXPECT_EQ(inner, 128);
  EXPECT_EQ(elsewhere, 0);
}

TEST_P(TasksOfThreads, ConcurrentCallersEachGetTheirOwnWork) {
  Tasks tasks(GetParam());
  std::vector<std::jthread> callers;
  std::vector<uint64_t> sums(6);
  for (size_t c = 0; c < sums.size(); ++c)
    callers.emplace_back([&tasks, &sum = sums[c], c] {
      for (int round = 0; round < 30; ++round) {
        std::vector<uint64_t> parts(64);
        tasks.parallel_for(parts.size(), [&](uint64_t i) { parts[i] = i + c; });
        sum += std::accumulate(parts.begin(), parts.end(), uint64_t{0});
      }
    });
  callers.clear();
  for (size_t c = 0; c < sums.size(); ++c) EXPECT_EQ(sums[c], 30 * (64 * 63 / 2 + 64 * c));
}

TEST(TasksOfARunner, EveryCallGoesThroughTheHostsRunner) {
  uint64_t asked = 0;
  Tasks tasks(
      [&](uint64_t count, const std::function<void(uint64_t)>& body) {
        asked += count;
        std::jthread other([&] {
          for (uint64_t i = 1; i < count; i += 2) body(i);
        });
        for (uint64_t i = 0; i < count; i += 2) body(i);
      },
      2);
  std::vector<int> calls(50);
  tasks.parallel_for(50, [&](uint64_t i) { ++calls[i]; });
  EXPECT_EQ(calls, std::vector<int>(50, 1));
  EXPECT_EQ(asked, 50u);
  EXPECT_THROW(tasks.parallel_for(50,
                                  [](uint64_t i) {
                                    if (i % 10 == 3) throw std::runtime_error("3");
                                  }),
               std::runtime_error);
}

} // namespace
} // namespace bccsplat
