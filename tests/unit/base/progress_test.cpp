// SPDX-License-Identifier: Apache-2.0
#include "base/progress.h"

#include <algorithm>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

TEST(Progress, ThreadsReportRisingFractionsOneAtATime) {
  std::vector<double> seen; // not locked: report() must not call twice at once
  Progress progress([&](double fraction) {
    seen.push_back(fraction);
    return 0;
  });
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&progress] {
      for (int i = 0; i <= 20000; ++i) progress.report(i / 20000.0);
    });
  threads.clear();
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_LE(seen.back(), 1);
}

TEST(Progress, AtMostThirtyReportsASecond) {
  int calls = 0;
  Progress progress([&](double) { return ++calls, 0; });
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 100000; ++i) progress.report(i / 200000.0);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(calls, 1 + 30 * took.count());
}

TEST(Progress, ANonZeroAnswerCancels) {
  Progress progress([](double) { return 1; });
  EXPECT_NO_THROW(progress.check());
  try {
    progress.report(0.5);
    ADD_FAILURE() << "went on";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::cancelled);
  }
  EXPECT_THROW(progress.check(), Error);
}

// The host hears of a stage that only checks, too, and may cancel.
TEST(Progress, ChecksAskTheHostToo) {
  std::vector<double> seen;
  Progress progress([&](double fraction) {
    seen.push_back(fraction);
    return seen.size() == 3;
  });
  progress.report(0.25);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(for (;;) progress.check(), Error);
  EXPECT_EQ(seen, std::vector<double>({0.25, 0.25, 0.25}));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(68));
}

TEST(Progress, CancelWorksWithoutACallback) {
  Progress progress;
  progress.report(0.5);
  progress.cancel();
  EXPECT_THROW(progress.report(0.6), Error);
}

} // namespace
// In stages within stages, what each reports is scaled to its share of the whole.
TEST(Progress, SharesNest) {
  double heard = 0;
  Progress whole(
      [&](double fraction) {
        heard = fraction;
        return 0;
      },
      true);
  Progress half(whole, 0.5, 1), quarter(half, 0.5, 1);
  quarter.advance(1, 2);
  EXPECT_EQ(heard, 0.875);
  Progress last(whole, 0.75, 1);
  last.advance(3, 3);
  EXPECT_EQ(heard, 1);
}

TEST(Progress, StagesAreNotHeardUnasked) {
  double heard = 0;
  Progress whole([&](double fraction) {
    heard = fraction;
    return 0;
  });
  Progress share(whole, 0, 1);
  share.advance(1, 1);
  EXPECT_EQ(heard, 0);
  whole.report(1);
  EXPECT_EQ(heard, 1);
}

TEST(Progress, SharesHearOfCancelling) {
  Progress whole;
  Progress share(whole, 0.25, 0.5);
  share.check();
  whole.cancel();
  EXPECT_TRUE(share.cancelled());
  EXPECT_THROW(share.check(), Error);
  EXPECT_THROW(share.advance(1, 2), Error);
}

} // namespace bccsplat
