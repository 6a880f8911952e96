// SPDX-License-Identifier: Apache-2.0
#include "volume/first_picture.h"

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

TEST(FirstPicture, TheFrameWhoseValuesSpanMost) {
  EXPECT_EQ(frame_that_shows_most({}), 0U) << "nothing is known";
  EXPECT_EQ(frame_that_shows_most({{0, 1}, {0, 5}, {0, 9}, {-20, 0}, {0, 3}}), 3U);
  EXPECT_EQ(frame_that_shows_most({{7, 7}, {7, 7}}), 0U) << "none shows anything";
}

TEST(FirstPicture, OfFramesAboutAsGoodTheMiddleOne) {
  EXPECT_EQ(frame_that_shows_most({{0, 100}, {0, 99}, {0, 98}, {0, 97}, {0, 96}}), 2U);
  EXPECT_EQ(frame_that_shows_most({{0, 100}, {0, 90}, {0, 90}, {0, 97}, {0, 20}}), 3U);
  EXPECT_EQ(frame_that_shows_most({{0, 1}, {0, 100}, {0, 100}, {0, 1}}), 1U) << "the earlier of two";
}

TEST(FirstPicture, LayoutsFollowFromTheKind) {
  using series::DataKind;
  EXPECT_EQ(kind_look(DataKind::mr).layout, Layout::both);
  EXPECT_EQ(kind_look(DataKind::ct).layout, Layout::both);
  EXPECT_EQ(kind_look(DataKind::map).layout, Layout::flat);
  for (const DataKind kind : {DataKind::unknown, DataKind::statistic, DataKind::labels, DataKind::field,
                              DataKind::smoke, DataKind::fire})
    EXPECT_EQ(kind_look(kind).layout, Layout::volume) << name_of(kind);
}

} // namespace
} // namespace bccsplat
