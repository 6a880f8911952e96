// SPDX-License-Identifier: Apache-2.0
// Days are counted by the usual formulas for the Julian day number, in which the year begins with March: the
// day that leap years add is the last one.
#include "readers/calendar.h"

#include <algorithm>
#include <cmath>

#include "readers/text.h"

namespace bcc4 {
namespace {

struct CalendarName {
  const char* name;
  Calendar calendar;
};
constexpr CalendarName kCalendars[] = {
    {"", Calendar::standard},          {"standard", Calendar::standard},
    {"gregorian", Calendar::standard}, {"proleptic_gregorian", Calendar::gregorian},
    {"julian", Calendar::julian},      {"noleap", Calendar::noleap},
    {"no_leap", Calendar::noleap},     {"365_day", Calendar::noleap},
    {"all_leap", Calendar::all_leap},  {"366_day", Calendar::all_leap},
    {"360_day", Calendar::days_360},   {"360", Calendar::days_360},
};

struct TimeUnit {
  const char* names;
  double seconds;
};
constexpr TimeUnit kTimeUnits[] = {
    {"ns nsec nsecs nanosecond nanoseconds", 1e-9},
    {"us usec usecs \u00B5s \u03BCs microsecond microseconds", 1e-6},
    {"ms msec msecs millisecond milliseconds", 1e-3},
    {"s sec secs second seconds", 1},
    {"min mins minute minutes", 60},
    {"h hr hrs hour hours", 3600},
    {"d day days", 86400},
    {"week weeks", 604800},
};

constexpr int kMostYear = 99999;

// Takes the parts of a date from the front of a text.
struct DateText {
  std::string_view rest;

  bool take(std::string_view any_of) {
    if (rest.empty() || any_of.find(rest.front()) == std::string_view::npos) return false;
    rest.remove_prefix(1);
    return true;
  }
  std::optional<int> whole(size_t most_digits) {
    size_t n = 0;
    while (n < rest.size() && rest[n] >= '0' && rest[n] <= '9') ++n;
    if (n == 0 || n > most_digits) return std::nullopt;
    const auto value = parse_number<int>(rest.substr(0, n));
    rest.remove_prefix(n);
    return value;
  }
  std::optional<double> decimal() {
    const size_t n = std::min(rest.find_first_not_of("0123456789."), rest.size());
    const auto value = parse_number<double>(rest.substr(0, n));
    rest.remove_prefix(n);
    return value;
  }
};

// Takes "21", "21:30" or "21:30:00.5" as seconds.
std::optional<double> take_clock(DateText& text) {
  const auto hours = text.whole(2);
  if (!hours || *hours > 24) return std::nullopt;
  double seconds = 3600.0 * *hours;
  if (!text.take(":")) return seconds;
  const auto minutes = text.whole(2);
  if (!minutes || *minutes > 59) return std::nullopt;
  seconds += 60.0 * *minutes;
  if (!text.take(":")) return seconds;
  const auto rest = text.decimal();
  if (!rest || *rest > 60) return std::nullopt;
  return seconds + *rest;
}

// Reads what is behind the clock, "", "Z", "UTC", "+01:00" or "-0600", as seconds east of longitude 0.
std::optional<double> zone_seconds(std::string_view zone) {
  const std::string name = lower(trim(zone));
  if (name.empty() || name == "z" || name == "utc" || name == "gmt") return 0;
  DateText text{name};
  const double sign = name.front() == '-' ? -1 : 1;
  if (!text.take("+-")) return std::nullopt;
  if (text.rest.size() == 4 && text.rest.find(':') == std::string_view::npos) {
    const auto both = text.whole(4);
    if (!both || *both % 100 > 59) return std::nullopt;
    return sign * (3600.0 * (*both / 100) + 60.0 * (*both % 100));
  }
  const auto seconds = take_clock(text);
  if (!seconds || !text.rest.empty()) return std::nullopt;
  return sign * *seconds;
}

bool is_leap(int year, Calendar calendar) {
  if (calendar == Calendar::noleap || calendar == Calendar::days_360) return false;
  if (calendar == Calendar::all_leap) return true;
  const bool julian = calendar == Calendar::julian || (calendar == Calendar::standard && year <= 1582);
  return year % 4 == 0 && (julian || year % 100 != 0 || year % 400 == 0);
}

int month_days(int year, int month, Calendar calendar) {
  if (calendar == Calendar::days_360) return 30;
  if (month == 2) return is_leap(year, calendar) ? 29 : 28;
  return month == 4 || month == 6 || month == 9 || month == 11 ? 30 : 31;
}

bool plausible(const Date& d) {
  return d.year >= 0 && d.year <= kMostYear && d.month >= 1 && d.month <= 12 && d.day >= 1 && d.day <= 31;
}

} // namespace

std::optional<Calendar> calendar_by_name(std::string_view name) {
  const std::string wanted = lower(trim(name));
  for (const auto& [known, calendar] : kCalendars)
    if (wanted == known) return calendar;
  return std::nullopt;
}

std::optional<Date> parse_date(std::string_view text) {
  DateText parts{trim(text)};
  const auto year = parts.whole(5);
  if (!year || !parts.take("-")) return std::nullopt;
  const auto month = parts.whole(2);
  if (!month || !parts.take("-")) return std::nullopt;
  const auto day = parts.whole(2);
  if (!day) return std::nullopt;
  Date date{*year, *month, *day, 0};
  if (!plausible(date)) return std::nullopt;
  if (parts.rest.empty()) return date;
  if (!parts.take(" _Tt")) return std::nullopt;
  parts.rest = trim(parts.rest);
  const auto clock = take_clock(parts);
  const auto zone = zone_seconds(parts.rest);
  if (!clock || !zone) return std::nullopt;
  date.seconds = *clock - *zone;
  return date;
}

std::optional<Date> date_of_number(double number) {
  if (!(number >= 101 && number < 1e4 * (kMostYear + 1))) return std::nullopt;
  const auto whole = static_cast<int>(number);
  const Date date{whole / 10000, whole / 100 % 100, whole % 100, (number - whole) * 86400};
  return plausible(date) ? std::optional(date) : std::nullopt;
}

std::string day_text(const Date& date) {
  const auto padded = [](int value, size_t width) {
    const std::string digits = concat(value);
    return std::string(width - std::min(width, digits.size()), '0') + digits;
  };
  return concat(padded(date.year, 4), '-', padded(date.month, 2), '-', padded(date.day, 2));
}

std::optional<int64_t> day_number(const Date& date, Calendar calendar) {
  if (!plausible(date) || date.day > month_days(date.year, date.month, calendar)) return std::nullopt;
  const int64_t day = date.day, year = date.year;
  if (calendar == Calendar::days_360) return 360 * year + 30 * (date.month - 1) + day;
  const int64_t before = date.month < 3 ? 1 : 0; // the year that began with March
  const int64_t y = year + 4800 - before, m = date.month + 12 * before - 3;
  const int64_t of_year = (153 * m + 2) / 5 + day + 365 * y;
  if (calendar == Calendar::noleap) return of_year;
  if (calendar == Calendar::all_leap) return of_year + y;
  const int64_t sorted = 10000 * year + 100 * date.month + day;
  if (calendar == Calendar::standard && sorted > 15821004 && sorted < 15821015) return std::nullopt;
  if (calendar == Calendar::julian || (calendar == Calendar::standard && sorted < 15821015))
    return of_year + y / 4 - 32083;
  return of_year + y / 4 - y / 100 + y / 400 - 32045;
}

std::optional<double> seconds_between(const Date& a, const Date& b, Calendar calendar) {
  const auto from = day_number(a, calendar), to = day_number(b, calendar);
  if (!from || !to) return std::nullopt;
  return 86400.0 * static_cast<double>(*to - *from) + (b.seconds - a.seconds);
}

std::optional<double> seconds_in(std::string_view unit) {
  const std::string wanted = lower(trim(unit));
  for (const auto& [names, seconds] : kTimeUnits)
    for (const std::string_view name : split(names))
      if (wanted == name) return seconds;
  return std::nullopt;
}

namespace {

constexpr double kDay = 86400;
constexpr int kMonths = 12;

// Returns the date of a day number: the year by its length, then the month, then the day.
std::optional<Date> date_of_day(int64_t number, Calendar calendar) {
  constexpr double days_of_year = 365.25, days_of_360 = 360;
  const auto first = day_number({0, 1, 1, 0}, calendar);
  if (!first || number < *first) return std::nullopt;
  const double length = calendar == Calendar::days_360 ? days_of_360 : days_of_year;
  Date date{static_cast<int>(static_cast<double>(number - *first) / length), 1, 1, 0};
  const auto begins = [&](int year, int month) {
    return day_number({year, month, 1, 0}, calendar).value_or(number + 1);
  };
  while (date.year > 0 && begins(date.year, 1) > number) --date.year;
  while (date.year < kMostYear && begins(date.year + 1, 1) <= number) ++date.year;
  while (date.month < kMonths && begins(date.year, date.month + 1) <= number) ++date.month;
  for (int day = 1; day <= month_days(date.year, date.month, calendar); ++day) {
    date.day = day; // days are missing where Julian becomes Gregorian
    if (day_number(date, calendar) == number) return date;
  }
  return std::nullopt;
}

std::optional<Date> after_seconds(const Date& from, double seconds, Calendar calendar) {
  const auto day = day_number(from, calendar);
  constexpr double rounding = 1e-4; // of a second, which sums of steps are off by
  const double all = from.seconds + seconds, days = std::floor((all + rounding) / kDay);
  if (!day || !(std::abs(days) < kMostYear * 400.0)) return std::nullopt;
  auto date = date_of_day(*day + static_cast<int64_t>(days), calendar);
  if (date) date->seconds = std::max(0.0, all - days * kDay);
  return date;
}

std::optional<Date> after_months(const Date& from, double months, Calendar calendar) {
  const double whole = std::floor(months);
  if (!(std::abs(whole) < 12.0 * kMostYear)) return std::nullopt;
  const int64_t sum = int64_t{kMonths} * from.year + from.month - 1 + static_cast<int64_t>(whole);
  if (sum < 0) return std::nullopt;
  Date date{static_cast<int>(sum / kMonths), static_cast<int>(sum % kMonths) + 1, from.day, from.seconds};
  const int days = month_days(date.year, date.month, calendar);
  date.day = std::min(date.day, days);
  return after_seconds(date, (months - whole) * days * kDay, calendar);
}

} // namespace

std::optional<Date> date_after(const Date& from, double count, std::string_view unit, Calendar calendar) {
  const std::string name = lower(trim(unit));
  if (name == "month" || name == "months") return after_months(from, count, calendar);
  if (name == "year" || name == "years") return after_months(from, kMonths * count, calendar);
  const auto seconds = seconds_in(name);
  return seconds ? after_seconds(from, count * *seconds, calendar) : std::nullopt;
}

std::string date_text(const Date& date) {
  constexpr double hour = 3600, minute = 60, thousand = 1000;
  const double rounded = std::round(date.seconds * thousand) / thousand;
  const auto two = [](double n) { return concat(n < 10 ? "0" : "", std::floor(n)); };
  const double seconds = std::round(std::fmod(rounded, minute) * thousand) / thousand;
  std::string text =
      concat(day_text(date), ' ', two(rounded / hour), ':', two(std::fmod(rounded, hour) / minute));
  if (seconds != 0) text += concat(':', seconds < 10 ? "0" : "", seconds);
  return text;
}

} // namespace bcc4
