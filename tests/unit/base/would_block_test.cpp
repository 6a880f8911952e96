// SPDX-License-Identifier: Apache-2.0
// Ranges of bytes that are merged, and calls that hear of all they lack.
#include "base/would_block.h"

#include <gtest/gtest.h>

#include "base/files.h"
#include "base/tasks.h"

namespace bccsplat {
namespace {

using Ranges = std::vector<ByteRange>;

Ranges merged(Ranges ranges, uint64_t gap) {
  merge_ranges(ranges, gap);
  return ranges;
}

TEST(ByteRanges, AreMergedOverGaps) {
  EXPECT_EQ(merged({}, 9), Ranges{});
  EXPECT_EQ(merged({{5, 0}}, 9), Ranges{});
  EXPECT_EQ(merged({{20, 5}, {0, 10}}, 9), (Ranges{{0, 10}, {20, 5}}));
  EXPECT_EQ(merged({{20, 5}, {0, 10}}, 10), (Ranges{{0, 25}}));
  EXPECT_EQ(merged({{10, 5}, {0, 10}}, 0), (Ranges{{0, 15}}));
  EXPECT_EQ(merged({{0, 10}, {2, 3}, {9, 4}}, 0), (Ranges{{0, 13}}));
  EXPECT_EQ(merged({{0, 1}, {UINT64_MAX - 9, 9}}, UINT64_MAX), (Ranges{{0, UINT64_MAX}}));
}

TEST(Attempts, GatherWhatAllOfThemLack) {
  Tasks tasks(4);
  Attempts attempts;
  attempts.throw_if_waiting(); // nothing was tried
  tasks.parallel_for(50, [&](uint64_t i) {
    const bool good = attempts.attempt([&] {
      if (i % 2 == 0) throw WouldBlock("late", {{100 * i, 10}});
    });
    EXPECT_EQ(good, i % 2 == 1);
  });
  EXPECT_THROW(attempts.attempt([] { fail(Code::io_error, "broken"); }), Error);
  try {
    attempts.throw_if_waiting();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::would_block);
    const auto* late = dynamic_cast<const WouldBlock*>(&e);
    ASSERT_NE(late, nullptr);
    EXPECT_EQ(merged(late->lacking(), 0).size(), 25u);
  }
}

TEST(StreamSink, IsFlushedWhereThereIsSomethingToFlush) {
  int flushes = 0;
  bool good = true;
  const auto sink = create_stream_sink(
      [](uint64_t, std::span<const std::byte> bytes) { return static_cast<int64_t>(bytes.size()); },
      [&] { return ++flushes, good; });
  sink->flush();
  EXPECT_EQ(flushes, 0);
  const std::array<std::byte, 3> bytes{};
  sink->write_at(0, bytes);
  sink->flush();
  sink->commit();
  EXPECT_EQ(flushes, 1);
  sink->write_at(0, bytes);
  good = false;
  EXPECT_THROW(sink->commit(), Error);
}

} // namespace
} // namespace bccsplat
