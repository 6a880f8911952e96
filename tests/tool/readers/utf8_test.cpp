// SPDX-License-Identifier: Apache-2.0
#include "readers/text.h"

#include <gtest/gtest.h>

namespace bcc4::test {
namespace {

TEST(Utf8, TextsOfItStayAsTheyAre) {
  for (const char* text :
       {"", "mm", "\xc2\xb5m", "\xe2\x82\xac", "\xed\x9f\xbf", "\xf0\x9f\x8c\x8a", "\xf4\x8f\xbf\xbf"})
    EXPECT_EQ(utf8_of(text), text);
}

TEST(Utf8, SequencesAreWellFormedOrNone) {
  EXPECT_EQ(bccsplat::utf8_sequence("a"), 1u);
  EXPECT_EQ(bccsplat::utf8_sequence("\xc2\xb5m"), 2u);
  EXPECT_EQ(bccsplat::utf8_sequence("\xe2\x82\xac"), 3u);
  EXPECT_EQ(bccsplat::utf8_sequence("\xf0\x9f\x8c\x8a"), 4u);
  for (const char* wrong :
       {"", "\xb5", "\xc2", "\xc0\x80", "\xc1\xbf", "\xe2\x82", "\xe0\x9f\xbf", "\xed\xa0\x80",
        "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"})
    EXPECT_EQ(bccsplat::utf8_sequence(wrong), 0u);
}

TEST(Utf8, OthersAreLatin1) {
  EXPECT_EQ(utf8_of("\xb5m"), "\xc2\xb5m");
  EXPECT_EQ(utf8_of("\xe5ngstr\xf6m"), "\xc3\xa5ngstr\xc3\xb6m");
  // All of a text is one or the other.
  EXPECT_EQ(utf8_of("\xc2\xb5m \xb5m"), "\xc3\x82\xc2\xb5m \xc2\xb5m");
}

} // namespace
} // namespace bcc4::test
