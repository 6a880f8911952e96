// SPDX-License-Identifier: Apache-2.0
// Cube roots are the nearest numbers, also where the system's own is off by the last bit.
#include "base/cube_root.h"

#include <gtest/gtest.h>

#include <array>

namespace bccsplat {
namespace {

TEST(CubeRoot, IsTheNearestNumber) {
  // By 60 decimal digits; of the last six glibc 2.36 gives a neighbour.
  constexpr std::array<std::array<double, 2>, 15> known{{
      {0x1.0000000000000p+3, 0x1.0000000000000p+1},
      {0x1.b000000000000p+4, 0x1.8000000000000p+1},
      {0x1.0000000000000p-3, 0x1.0000000000000p-1},
      {-0x1.f400000000000p+9, -0x1.4000000000000p+3},
      {0x1.0000000000000p+1, 0x1.428a2f98d728bp+0},
      {0x1.999999999999ap-4, 0x1.db4c7760bcff3p-2},
      {0x1.a01439c8ce906p-1, 0x1.ddcaaafe21983p-1},
      {0x1.4484bfeebc2a0p-100, 0x1.b7cdfd9d7bdbbp-34},
      {0x1.60a5f7552857cp+134, 0x1.c4296e5c3d297p+44},
      {0x1.9190dc88e09c3p+4, 0x1.76c313c55d76bp+1},
      {0x1.4287075149dd0p+4, 0x1.5c5b98c35d39cp+1},
      {0x1.241d3ac83f8cbp+4, 0x1.510b7268d0df5p+1},
      {0x1.a1162962817b0p+3, 0x1.2d3b8f13deec9p+1},
      {0x1.ae9cea93d8af0p+3, 0x1.3074577d80de4p+1},
      {0x1.cf2272a8935f8p+2, 0x1.ef29fa11507e1p+0},
  }};
  for (const auto& [x, root] : known) EXPECT_EQ(cube_root(x), root) << x;
  EXPECT_EQ(cube_root(0), 0);
}

TEST(CubeRoot, OfCubesIsExact) {
  for (double y = 1; y < 3000; ++y) EXPECT_EQ(cube_root(y * y * y), y);
}

} // namespace
} // namespace bccsplat
