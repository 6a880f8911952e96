// SPDX-License-Identifier: Apache-2.0
#include "points/time_axis.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace bccsplat {
namespace {

TEST(TimeAxis, OfOneFrameHasItsTime) {
  // In memory that holds other numbers behind the one.
  std::vector<double> times{7.5, 1e9, 1e9, 1e9};
  times.resize(1);
  const TimeAxis axis(std::move(times));
  EXPECT_EQ(axis.time_of(0), 7.5);
  EXPECT_EQ(axis.index_of(7.5), 0);
  EXPECT_EQ(axis.first(), axis.last());
  EXPECT_FALSE(axis.holds(8));
  EXPECT_THROW((void)axis.time_of(1), Error);
}

} // namespace
} // namespace bccsplat
