// SPDX-License-Identifier: Apache-2.0
#include "store/gap_warning.h"

#include <gtest/gtest.h>

#include <vector>

namespace bccsplat {
namespace {

std::string warning(const std::vector<double>& times, const std::vector<uint32_t>& measured = {}) {
  return gap_warning(times, measured);
}

TEST(GapWarning, TellsTheWidestGapThatNobodyMeasured) {
  EXPECT_EQ(warning({}), "");
  EXPECT_EQ(warning({4}), "");
  EXPECT_EQ(warning({4, 90}), "") << "one step is the usual one";
  EXPECT_EQ(warning({0, 2, 4, 10, 12, 14}), "") << "three steps are none";
  const std::vector<double> times{0, 2, 4, 10.5, 12, 14, 30, 32};
  EXPECT_EQ(warning(times).find("frames 5 and 6 are 16 apart, others 2: "), 0u) << warning(times);
  EXPECT_EQ(warning(times, {0, 6, 7}), warning(times)) << "one side says nothing of the other";
  EXPECT_EQ(warning(times, {5, 6}).find("frames 2 and 3 are 6.5 apart"), 0u);
  EXPECT_EQ(warning(times, {2, 3, 5, 6}), "");
}

} // namespace
} // namespace bccsplat
