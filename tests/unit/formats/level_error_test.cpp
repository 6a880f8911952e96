// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/level_error.h"

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

VolumeInfo of_ten_thousand_sites() {
  VolumeInfo info;
  info.lattice = Lattice4::fit(LatticeKind::cc, {20, 10, 10, 10});
  info.channels.resize(2);
  for (ChannelInfo& c : info.channels) c.sites_kept = info.lattice.sites();
  return info;
}

MeasuredError measured(uint32_t channel, uint32_t level, MeasuredError::Kind kind, double rmse) {
  return {channel, level, kind, 3, 1000, rmse, 4 * rmse, 100};
}

TEST(LevelError, IsWhatALevelAddsToTheFinest) {
  VolumeInfo info = of_ten_thousand_sites();
  EXPECT_FALSE(level_error(info, 0, 1)) << "nothing was measured";
  info.errors = {measured(0, 1, MeasuredError::stored, 0.5)};
  EXPECT_DOUBLE_EQ(level_error(info, 0, 1)->rmse, 0.005) << "level 0 was not";
  EXPECT_DOUBLE_EQ(level_error(info, 0, 1)->largest, 0.02);
  EXPECT_FALSE(level_error(info, 1, 1)) << "another channel";
  info.errors.insert(info.errors.begin(), measured(0, 0, MeasuredError::stored, 0.4));
  EXPECT_DOUBLE_EQ(level_error(info, 0, 1)->rmse, 0.003);
  EXPECT_DOUBLE_EQ(level_error(info, 0, 1)->largest, 0.02);
  EXPECT_EQ(level_error(info, 0, 0)->rmse, 0);
  info.errors[0].rmse = 0.6;
  EXPECT_EQ(level_error(info, 0, 1)->rmse, 0) << "no worse than level 0";
}

TEST(LevelError, ComparesWithTheCorrectedFieldWhereThereIsOne) {
  VolumeInfo info = of_ten_thousand_sites();
  info.errors = {measured(0, 0, MeasuredError::stored, 0.5), measured(0, 0, MeasuredError::corrected, 0.3),
                 measured(0, 1, MeasuredError::stored, 0.5)};
  EXPECT_DOUBLE_EQ(level_error(info, 0, 1)->rmse, 0.004);
}

TEST(LevelError, IsOfThePartThatIsKept) {
  VolumeInfo info = of_ten_thousand_sites();
  info.channels[0].sites_kept /= 4;
  info.errors = {measured(0, 1, MeasuredError::stored, 0.5)};
  EXPECT_DOUBLE_EQ(level_error(info, 0, 1)->rmse, 0.01);
}

TEST(LevelError, NeedsARangeAndSamples) {
  VolumeInfo info = of_ten_thousand_sites();
  info.errors = {measured(0, 1, MeasuredError::stored, 0.5), measured(1, 1, MeasuredError::stored, 0.5)};
  info.errors[0].range = 0, info.errors[1].samples = 0;
  EXPECT_FALSE(level_error(info, 0, 1));
  EXPECT_FALSE(level_error(info, 1, 1));
}

} // namespace
} // namespace bccsplat
