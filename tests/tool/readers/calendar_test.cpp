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

std::string after(const char* epoch, double count, const char* unit, Calendar calendar) {
  const auto date = date_after(parse_date(epoch).value(), count, unit, calendar);
  return date ? date_text(*date) : "";
}

TEST(Calendar, FindsTheDateAfterSomeTime) {
  EXPECT_EQ(after("2000-02-27", 2.5, "days", Calendar::noleap), "2000-03-01 12:00");
  EXPECT_EQ(after("2000-02-27", 2.5, "days", Calendar::standard), "2000-02-29 12:00");
  EXPECT_EQ(after("2000-02-27", 3, "days", Calendar::days_360), "2000-02-30 00:00");
  EXPECT_EQ(after("1582-10-04", 1, "day", Calendar::standard), "1582-10-15 00:00");
  EXPECT_EQ(after("2000-03-01", -1, "d", Calendar::julian), "2000-02-29 00:00");
  EXPECT_EQ(after("1960-01-01", 13.5, "months", Calendar::days_360), "1961-02-16 00:00");
  EXPECT_EQ(after("1960-01-31", 1, "months", Calendar::standard), "1960-02-29 00:00");
  EXPECT_EQ(after("2000-01-01 06:00", 1.5, "years", Calendar::noleap), "2001-07-01 06:00");
  EXPECT_EQ(after("2000-01-01", 7.5, "s", Calendar::standard), "2000-01-01 00:00:07.5");
  EXPECT_EQ(after("2000-01-01", 86399.99999, "s", Calendar::standard), "2000-01-02 00:00");
  EXPECT_EQ(after("2000-01-01", 1, "furlongs", Calendar::standard), "");
}

TEST(Calendar, ComesBackFromEveryDay) {
  for (const Calendar calendar : {Calendar::standard, Calendar::gregorian, Calendar::julian, Calendar::noleap,
                                  Calendar::all_leap, Calendar::days_360})
    for (int days = 0; days < 1600; ++days) {
      const Date from = parse_date("1580-12-28").value();
      const Date date = date_after(from, days, "days", calendar).value();
      ASSERT_EQ(seconds_between(from, date, calendar), 86400.0 * days) << day_text(date);
    }
}

} // namespace
} // namespace bcc4::test
