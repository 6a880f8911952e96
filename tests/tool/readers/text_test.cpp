// SPDX-License-Identifier: Apache-2.0
#include "readers/text.h"

#include <gtest/gtest.h>

namespace bcc4::test {
namespace {

TEST(Text, WritesNumbersAsPeopleDo) {
  EXPECT_EQ(byte_text(1000.0 * 1024), "1000 KiB");
  EXPECT_EQ(byte_text(1023.7 * 1024), "1024 KiB");
  EXPECT_EQ(byte_text(1536), "1.5 KiB");
  EXPECT_EQ(byte_text(4.0 * 1024 * 1024), "4 MiB");
  EXPECT_EQ(short_number(9192.4, 3), "9192");
  EXPECT_EQ(short_number(999.7, 3), "1000");
  EXPECT_EQ(short_number(-123456.7, 4), "-123457");
  EXPECT_EQ(short_number(12.3456, 4), "12.35");
  EXPECT_EQ(short_number(1.5e-7, 4), "1.5e-07");
  EXPECT_EQ(short_number(2e30, 4), "2e+30");
  EXPECT_EQ(concat(100000.0), "100000");
  EXPECT_EQ(concat(-2.5e9f), "-2500000000");
  EXPECT_EQ(concat(0.1), "0.1");
  EXPECT_EQ(concat(1e300), "1e+300");
  for (const double v : {123456789.25, 3e14, 1e15, 98765432109876.5})
    EXPECT_EQ(parse_number<double>(concat(v)), v);
}

TEST(Text, DigitsTellValuesApart) {
  EXPECT_EQ(digits_apart(1, 0.5, 6), 6);
  EXPECT_EQ(digits_apart(1e6, 0.0625, 6), 10);
  EXPECT_EQ(digits_apart(-1e9, 1, 6), 11);
  EXPECT_EQ(digits_apart(1, 1e-300, 6), 17);
  for (const double value : {0.0, 7.0}) EXPECT_EQ(digits_apart(value, 0, 5), 5);
  EXPECT_EQ(digits_apart(0, 3, 5), 5);
}

} // namespace
} // namespace bcc4::test
