// SPDX-License-Identifier: Apache-2.0
#include "base/grid.h"

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

TEST(Grid, PlacesAreRowByRow) {
  EXPECT_EQ(plane_index(3, 2, 16), 35u);
  EXPECT_EQ(plane_offset(3, 2, 16), 35);
  EXPECT_EQ(plane_size(16, 3), plane_index(0, 3, 16));
}

TEST(Grid, PlacesBeforeTheFirstAreNegative) {
  EXPECT_EQ(plane_offset(-1, -2, 16), -33);
  EXPECT_EQ(plane_offset(2, -1, 16), -14);
}

TEST(Grid, PlanesMayHoldMoreThanAnIntCounts) {
  EXPECT_EQ(plane_index(65535, 65535, 65536), 4294967295u);
  EXPECT_EQ(plane_offset(65535, 65535, 65536), 4294967295);
  EXPECT_EQ(plane_size(65536, 65536), 4294967296u);
}

} // namespace
} // namespace bccsplat
