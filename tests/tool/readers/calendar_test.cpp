// SPDX-License-Identifier: Apache-2.0
#include "readers/calendar.h"

#include <gtest/gtest.h>

namespace bcc4::test {
namespace {

double hours_between(const char* a, const char* b, Calendar calendar = Calendar::standard) {
  return seconds_between(parse_date(a).value(), parse_date(b).value(), calendar).value() / 3600;
}

TEST(Calendar, ReadsDatesInTheirForms) {
  for (const char* text : {"2000-01-31_12:00:00", "2000-1-31 12:0:0.0", "2000-01-31T12:00Z",
                           "2000-01-31 12:00:00 UTC", "2000-01-31 13:00 +01:00", "2000-01-31 06:00:00 -0600"})
    EXPECT_EQ(hours_between("2000-01-31", text), 12) << text;
  for (const char* text : {"", "2000", "2000-01", "2000-13-01", "2000-01-32", "0000-00-00 00:00", "soon",
                           "2000-01-01 25:00", "2000-01-01 12:61", "2000-01-01 12:00 MEZ"})
    EXPECT_FALSE(parse_date(text)) << text;
}

TEST(Calendar, CountsDaysByItsRules) {
  EXPECT_EQ(hours_between("2000-02-28", "2000-03-01"), 48);
  EXPECT_EQ(hours_between("1900-02-28", "1900-03-01"), 24);
  EXPECT_EQ(hours_between("1900-02-28", "1900-03-01", Calendar::julian), 48);
  EXPECT_EQ(hours_between("1582-10-04", "1582-10-15"), 24);
  EXPECT_EQ(hours_between("1582-10-04", "1582-10-15", Calendar::gregorian), 264);
  EXPECT_EQ(hours_between("2000-02-28", "2000-03-01", Calendar::noleap), 24);
  EXPECT_EQ(hours_between("2001-02-28", "2001-03-01", Calendar::all_leap), 48);
  EXPECT_EQ(hours_between("2000-02-28", "2000-03-01", Calendar::days_360), 72);
  EXPECT_FALSE(day_number({2000, 2, 29, 0}, Calendar::noleap));
  EXPECT_FALSE(day_number({1582, 10, 10, 0}, Calendar::standard));
  EXPECT_EQ(calendar_by_name("365_day"), Calendar::noleap);
  EXPECT_FALSE(calendar_by_name("mayan"));
}

TEST(Calendar, ReadsDatesThatAreNumbers) {
  const Date date = date_of_number(20000229.25).value();
  EXPECT_EQ(day_text(date), "2000-02-29");
  EXPECT_EQ(date.seconds, 21600);
  EXPECT_FALSE(date_of_number(20001301));
}

} // namespace
} // namespace bcc4::test
