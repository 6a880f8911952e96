// SPDX-License-Identifier: Apache-2.0
// Progress of calls: what hosts are told, how they cancel, and tokens that cancel for them.
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

TEST(Progress, ATokenCancelsWhatWatchesIt) {
  CancelToken token, other;
  Progress progress;
  progress.watch(&token), progress.watch(&other), progress.watch(nullptr);
  Progress share(progress, 0.5, 1);
  EXPECT_NO_THROW(share.check());
  other.cancel();
  EXPECT_TRUE(share.cancelled());
  EXPECT_THROW(share.check(), Error);
  EXPECT_THROW(progress.throw_if_cancelled(), Error);
}

// A reset is for what begins afterwards.
TEST(Progress, ATokenThatIsResetEndsWhatWasUnderWay) {
  CancelToken token;
  Progress under_way;
  under_way.watch(&token);
  token.cancel(), token.cancel(), token.reset();
  EXPECT_FALSE(token.cancelled());
  EXPECT_TRUE(under_way.cancelled());
  Progress later;
  later.watch(&token);
  EXPECT_FALSE(later.cancelled());
  EXPECT_NO_THROW(under_way.begin_call()); // another call
  EXPECT_NO_THROW(under_way.check());
  token.cancel();
  EXPECT_THROW(under_way.begin_call(), Error);
  EXPECT_TRUE(later.cancelled());
}

TEST(Progress, ManyThreadsCancelOnce) {
  CancelToken token;
  const uint64_t before = token.cancels();
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&token] {
        for (int i = 0; i < 1000; ++i) token.cancel();
      });
  }
  EXPECT_TRUE(token.cancelled());
  EXPECT_EQ(token.cancels(), before + 1);
}

} // namespace bccsplat
