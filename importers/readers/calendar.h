// SPDX-License-Identifier: Apache-2.0
// Dates as text and in the calendars of the CF conventions (chapter 4.4), and the units of time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace bcc4 {

// `standard` is Julian before 15 October 1582 and Gregorian from then on.
enum class Calendar : uint8_t { standard, gregorian, julian, noleap, all_leap, days_360 };
// Knows the names of the CF conventions in any letter case, and "360"; "" is the standard calendar.
[[nodiscard]] std::optional<Calendar> calendar_by_name(std::string_view name);

struct Date {
  int year = 0, month = 1, day = 1;
  double seconds = 0; // since midnight at longitude 0: a time zone may lead to another day
};

// Reads "2013-07-07", "2013-07-07_21:30:00", "2000-1-1T6:0:0.5Z" and the like, with a zone such as UTC or
// +01:00; nothing where the text is no date.
[[nodiscard]] std::optional<Date> parse_date(std::string_view text);
// Reads a date written as the number YYYYMMDD; the fraction of the number is that of the day.
[[nodiscard]] std::optional<Date> date_of_number(double number);
// Returns text such as "2000-02-28", the day alone.
[[nodiscard]] std::string day_text(const Date& date);

// Returns the days from a day that is the same for all dates of a calendar; nothing for days that it lacks.
[[nodiscard]] std::optional<int64_t> day_number(const Date& date, Calendar calendar);
// Returns the seconds from date `a` to date `b`; nothing where the calendar lacks one of them.
[[nodiscard]] std::optional<double> seconds_between(const Date& a, const Date& b, Calendar calendar);

// Returns the seconds in a unit such as "hours" or "d"; nothing for months and years, which have no one
// length.
[[nodiscard]] std::optional<double> seconds_in(std::string_view unit);

// Returns the date so many of the unit after another one. A month is one of the calendar, and a part of it
// that part of its days; a year is twelve. Nothing for units and dates that are not known.
[[nodiscard]] std::optional<Date> date_after(const Date& from, double count, std::string_view unit,
                                             Calendar calendar);
// Returns text such as "2000-03-01 12:00" or "2000-03-01 12:00:07.5".
[[nodiscard]] std::string date_text(const Date& date);

} // namespace bcc4
