// SPDX-License-Identifier: Apache-2.0
#include "readers/clock.h"

#include <limits>

#include "readers/calendar.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

// Since 1582 the standard calendar is the Gregorian one.
std::optional<Calendar> calendar_of(const Clock& clock) {
  const auto calendar = calendar_by_name(clock.calendar);
  const auto epoch = parse_date(clock.epoch);
  constexpr int since = 1583;
  if (calendar == Calendar::standard && epoch && epoch->year >= since) return Calendar::gregorian;
  return calendar;
}

bool same_calendar(const Clock& a, const Clock& b) {
  const auto calendar = calendar_of(a);
  return a.calendar == b.calendar || (calendar && calendar == calendar_of(b));
}

// Returns the seconds from the 0 of one to that of the other.
std::optional<double> seconds_apart(const Clock& from, const Clock& to) {
  if (from.epoch == to.epoch) return 0;
  const auto calendar = calendar_by_name(to.calendar);
  const auto a = parse_date(to.epoch), b = parse_date(from.epoch);
  return a && b && calendar ? seconds_between(*a, *b, *calendar) : std::nullopt;
}

} // namespace

Clock clock_of(const SeriesDescription& series) {
  return {series.times.unit, told(series, "time_epoch"), told(series, "time_calendar")};
}

std::string clock_text(const Clock& clock) {
  return concat(clock.unit, clock.epoch.empty() ? "" : " since ", clock.epoch,
                clock.calendar.empty() ? "" : concat(", calendar ", clock.calendar));
}

std::pair<Clock, Clock> told_by_both(Clock a, Clock b) {
  if (a.unit.empty()) a.unit = b.unit;
  if (b.unit.empty()) b.unit = a.unit;
  if (a.epoch.empty() || b.epoch.empty())
    for (Clock* const clock : {&a, &b}) clock->epoch.clear(), clock->calendar.clear();
  return {std::move(a), std::move(b)};
}

std::optional<ClockChange> clock_change(const Clock& from, const Clock& to) {
  if (!same_calendar(from, to)) return std::nullopt;
  if (from.epoch == to.epoch && from.unit == to.unit) return ClockChange{};
  const auto apart = seconds_apart(from, to);
  const auto a = seconds_in(from.unit), b = seconds_in(to.unit);
  if (!apart || !a || !b) return std::nullopt;
  return ClockChange{*a, *apart, *b};
}

bool convert_times(std::vector<double>& times, const Clock& from, const Clock& to) {
  if (const auto change = clock_change(from, to)) {
    for (double& t : times) t = (*change)(t);
    return true;
  }
  const auto calendar = calendar_by_name(from.calendar), wanted = calendar_by_name(to.calendar);
  const auto epoch = parse_date(from.epoch), zero = parse_date(to.epoch);
  const auto unit = seconds_in(to.unit);
  if (!calendar || !wanted || !epoch || !zero || !unit || !date_after(*epoch, 0, from.unit, *calendar))
    return false;
  for (double& t : times) {
    const auto date = date_after(*epoch, t, from.unit, *calendar);
    const auto seconds = date ? seconds_between(*zero, *date, *wanted) : std::nullopt;
    t = seconds ? *seconds / *unit : std::numeric_limits<double>::quiet_NaN();
  }
  return true;
}

} // namespace bcc4
