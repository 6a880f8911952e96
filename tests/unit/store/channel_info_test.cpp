// SPDX-License-Identifier: Apache-2.0
#include "store/channel_info.h"

#include <gtest/gtest.h>

#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

TEST(ChannelInfo, DescribesTheSource) {
  const Series s({20, 20, 20, 5}, [](double x, double y, double z, double t) {
    return x + y + z < 12 ? 0 : 1 + t + 0.01 * x;
  });
  FitOptions o = options_for(s);
  const Fitted f = run_fit(o, s);
  ChannelInfo info;
  describe_channel(f.report.channels[0], info);
  EXPECT_EQ(info.source_range, (Range{0, 5.19f}));
  ASSERT_EQ(info.frames.size(), 5u);
  for (uint32_t t = 0; t < 5; ++t) EXPECT_EQ(info.frames[t].high, static_cast<double>(s.at(19, 19, 19, t)));
  uint64_t relevant = 0;
  for (const float v : s.values) relevant += v != 0;
  EXPECT_EQ(info.cc_relevant, relevant);
  ASSERT_EQ(info.histogram.size(), 256u);
  uint64_t counted = 0;
  for (const uint64_t n : info.histogram) counted += n;
  EXPECT_EQ(counted, f.report.channels[0].sites_kept);
  for (size_t p = 1; p < info.percentiles.size(); ++p) {
    EXPECT_LT(info.percentiles[p - 1].percent, info.percentiles[p].percent);
    EXPECT_LE(info.percentiles[p - 1].value, info.percentiles[p].value);
  }
}

} // namespace
} // namespace bccsplat::test
