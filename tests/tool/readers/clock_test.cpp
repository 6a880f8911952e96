// SPDX-License-Identifier: Apache-2.0
// Times of one clock in the numbers of another.
#include "readers/clock.h"

#include <gtest/gtest.h>

namespace bcc4 {
namespace {

TEST(Clock, CountsFromItsDateInItsUnit) {
  const auto change = clock_change({"days", "1970-01-03", ""}, {"hours", "1970-01-01", ""});
  ASSERT_TRUE(change);
  EXPECT_EQ((*change)(1.5), 84);
  EXPECT_FALSE(clock_change({"days", "1970-01-01", "noleap"}, {"days", "1970-01-01", "standard"}));
  EXPECT_FALSE(clock_change({"months", "1970-01-01", ""}, {"days", "1970-01-01", ""}));
}

TEST(Clock, StandardCalendarIsGregorianSince1582) {
  const auto change =
      clock_change({"days", "1900-01-01", "standard"}, {"days", "1899-12-31", "proleptic_gregorian"});
  ASSERT_TRUE(change);
  EXPECT_EQ((*change)(1), 2);
  EXPECT_FALSE(
      clock_change({"days", "1500-01-01", "standard"}, {"days", "1899-12-31", "proleptic_gregorian"}));
}

} // namespace
} // namespace bcc4
