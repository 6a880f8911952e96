// SPDX-License-Identifier: Apache-2.0
#include "fit/frame/box_overlap.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

FrameBox box(std::array<int64_t, 3> begin, std::array<int64_t, 3> dims) {
  FrameBox b;
  b.begin = begin, b.dims = dims;
  return b;
}

// A grid of boxes without gaps, in any order.
std::vector<FrameBox> tiles(int64_t n, std::array<int64_t, 3> dims, std::mt19937& random) {
  std::vector<FrameBox> all;
  for (int64_t z = 0; z < n; ++z)
    for (int64_t y = 0; y < n; ++y)
      for (int64_t x = 0; x < n; ++x) all.push_back(box({x * dims[0], y * dims[1], z * dims[2]}, dims));
  std::shuffle(all.begin(), all.end(), random);
  return all;
}

bool meet(const FrameBox& a, const FrameBox& b) {
  for (size_t k = 0; k < 3; ++k)
    if (std::max(a.begin[k], b.begin[k]) >= std::min(a.begin[k] + a.dims[k], b.begin[k] + b.dims[k]))
      return false;
  return true;
}

TEST(BoxOverlap, NoneAmongTilesThatTouch) {
  std::mt19937 random(1);
  EXPECT_FALSE(find_overlap({}));
  for (const int64_t n : {1, 2, 5, 40}) EXPECT_FALSE(find_overlap(tiles(n, {8, 8, 8}, random))) << n;
  EXPECT_FALSE(find_overlap(tiles(12, {3, 5, 1}, random)));
}

TEST(BoxOverlap, OneMoreAmongThemIsFound) {
  std::mt19937 random(2);
  std::vector<FrameBox> all = tiles(20, {8, 8, 8}, random);
  all.push_back(box({75, 80, 80}, {1, 1, 1}));
  const auto found = find_overlap(all);
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)[1], all.size() - 1);
  EXPECT_LT((*found)[0], (*found)[1]);
  EXPECT_TRUE(meet(all[(*found)[0]], all[(*found)[1]]));
}

// Against comparing each with each, for sets in which overlaps are rare and common.
TEST(BoxOverlap, AgreesWithComparingAll) {
  std::mt19937 random(3);
  int with = 0, without = 0;
  for (int round = 0; round < 400; ++round) {
    const int64_t room = 20 + 10 * (round % 20);
    std::uniform_int_distribution<int64_t> place(0, room), length(1, 1 + room / 8);
    std::vector<FrameBox> all;
    for (int i = 0; i < 40; ++i)
      all.push_back(box({place(random), place(random), place(random)},
                        {length(random), length(random), round % 3 ? 1 : length(random)}));
    bool any = false;
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t j = 0; j < i; ++j) any = any || meet(all[i], all[j]);
    const auto found = find_overlap(all);
    ASSERT_EQ(found.has_value(), any) << round;
    ASSERT_TRUE(!found || meet(all[(*found)[0]], all[(*found)[1]]));
    ++(any ? with : without);
  }
  EXPECT_GT(with, 20);
  EXPECT_GT(without, 20);
}

// Boxes that all start together have no plane between them.
TEST(BoxOverlap, NestedBoxes) {
  std::vector<FrameBox> all;
  for (int64_t n = 1; n <= 50; ++n) all.push_back(box({0, 0, 0}, {n, n, n}));
  EXPECT_TRUE(find_overlap(all));
}

} // namespace
} // namespace bccsplat
