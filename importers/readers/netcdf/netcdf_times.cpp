// SPDX-License-Identifier: Apache-2.0
// The coordinate variable of time has the word, in whatever form its units say; where there is none, a
// variable of text that holds a date for each frame.
#include "readers/netcdf/netcdf_times.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "readers/calendar.h"
#include "readers/clock.h"
#include "readers/error.h"
#include "readers/netcdf/netcdf_values.h"

namespace bcc4 {
namespace {

// Returns the text of dates along the dimension: WRF's Times(Time, DateStrLen), and others called like the
// dimension with or without an s.
const NetcdfVariable* dates_along(const NetcdfFile& file, const NetcdfVariable& v,
                                  const NetcdfDimension& dim) {
  for (const std::string& name : {dim.name, dim.name + "s", std::string("Times")})
    if (const NetcdfVariable* found = file.near(v, name); found && found->text && !found->dims.empty() &&
                                                          found->dims.size() <= 2 &&
                                                          found->dims[0].id == dim.id)
      return found;
  return nullptr;
}

// Makes dates times since `epoch`, the text of a date at or before the first one.
void set_dates(NetcdfTimes& times, const std::vector<Date>& dates, const std::string& unit,
               const std::string& epoch) {
  const auto calendar = calendar_by_name(times.calendar);
  const auto zero = parse_date(epoch);
  for (const Date& date : dates) {
    const auto seconds = calendar && zero ? seconds_between(*zero, date, *calendar) : std::nullopt;
    if (!seconds) {
      times.values.clear();
      times.unread = concat(day_text(date), " is no day of the calendar \"", times.calendar, "\"");
      return;
    }
    times.values.push_back(*seconds / seconds_in(unit).value());
  }
  times.unit = unit;
  times.epoch = epoch;
}

// Returns numbers of time along the dimension, or the only one (null), in a variable of another name: by its
// standard name, its own, or as the only one with a date.
const NetcdfVariable* times_beside(const NetcdfFile& file, const NetcdfVariable& v,
                                   const NetcdfDimension* dim) {
  const NetcdfVariable *named = nullptr, *dated = nullptr;
  size_t dates = 0;
  for (const NetcdfVariable& other : file.variables()) {
    const bool along = dim ? other.dims.size() == 1 && other.dims[0].id == dim->id : other.dims.empty();
    if (!along || !other.type || file.near(v, other.leaf) != &other) continue;
    const std::string standard = file.text(other, "standard_name"), units = file.text(other, "units");
    if (standard == "time") return &other;
    if (!standard.empty()) continue; // of the reference of a forecast, and the like
    if (lower(other.leaf) == "time") named = &other;
    if (units.find(" since ") != std::string::npos) dated = &other, ++dates;
  }
  return named ? named : dates == 1 ? dated : nullptr;
}

NetcdfTimes times_of_text(const NetcdfFile& file, const NetcdfVariable& text) {
  NetcdfTimes times;
  times.origin = concat("the dates in ", text.name);
  times.calendar = file.text(text, "calendar");
  std::vector<Date> dates;
  const std::vector<std::string> lines = file.lines(text);
  for (const std::string& line : lines) {
    const auto date = parse_date(line);
    if (!date) {
      times.unread = concat("\"", line.substr(0, 40), "\" is no date such as 2000-01-31_12:00:00");
      return times;
    }
    dates.push_back(*date);
  }
  if (lines.empty()) return times;
  std::string epoch(trim(lines[0]));
  if (const size_t behind_day = epoch.find_first_of("_Tt"); behind_day != std::string::npos)
    epoch[behind_day] = ' ';
  set_dates(times, dates, "hours", epoch);
  return times;
}

// Dates as the numbers YYYYMMDD and a fraction of the day, as of GrADS and CDO.
void set_numbered_dates(NetcdfTimes& times, const std::vector<double>& numbers) {
  std::vector<Date> dates;
  for (const double n : numbers) {
    const auto date = date_of_number(n);
    if (!date) {
      times.unread = concat(n, " is no date YYYYMMDD");
      return;
    }
    dates.push_back(*date);
  }
  if (!dates.empty()) set_dates(times, dates, "days", day_text(dates[0]));
}

NetcdfTimes times_of_numbers(const NetcdfFile& file, const NetcdfVariable& coordinate) {
  NetcdfTimes times;
  times.origin = concat(is_coordinate(coordinate) ? "coordinate variable " : "variable ", coordinate.name);
  times.calendar = file.text(coordinate, "calendar");
  const std::string units = file.text(coordinate, "units");
  const std::vector<double> numbers = coordinate_values(file, coordinate);
  if (units.find("%Y") != std::string::npos) {
    times.origin = concat("the dates in ", coordinate.name);
    if (lower(units).starts_with("day as %y%m%d"))
      set_numbered_dates(times, numbers);
    else
      times.unread = concat("they are written as \"", units, "\"");
    return times;
  }
  const size_t since = units.find(" since ");
  times.values = numbers;
  times.unit = std::string(trim(units.substr(0, since)));
  if (since != std::string::npos) times.epoch = std::string(trim(units.substr(since + 7)));
  return times;
}

bool rise(const std::vector<double>& values) {
  const auto falls = [](double a, double b) { return !(b > a); };
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }) &&
         std::adjacent_find(values.begin(), values.end(), falls) == values.end();
}

// Converts times to the unit and the date of `first`.
void count_from(const NetcdfTimes& first, NetcdfTimes& times, const std::string& path) {
  const Clock from{times.unit, times.epoch, times.calendar}, to{first.unit, first.epoch, first.calendar};
  const auto change = clock_change(from, to);
  if (!change)
    fail_input(path, ": its times are in \"", clock_text(from), "\", not as those of the first file in \"",
               clock_text(to), "\", and cannot be converted: give --dt or --times");
  for (double& t : times.values) t = (*change)(t);
}

} // namespace

NetcdfTimes netcdf_times(const NetcdfFile& file, const NetcdfVariable& v, const NetcdfDimension* dim) {
  if (const NetcdfVariable* coordinate = dim ? file.coordinate(v, *dim) : nullptr)
    return times_of_numbers(file, *coordinate);
  if (const NetcdfVariable* text = dim ? dates_along(file, v, *dim) : nullptr)
    return times_of_text(file, *text);
  const NetcdfVariable* const beside = times_beside(file, v, dim);
  if (!beside) return {};
  NetcdfTimes times = times_of_numbers(file, *beside);
  times.guessed = true;
  return times;
}

void NetcdfClock::add(NetcdfTimes times, uint64_t frames, const std::string& path) {
  if (times.values.size() != frames || !times.unread.empty()) {
    if (untold_.empty()) untold_ = path;
    if (all_.unread.empty()) all_.unread = times.unread;
  } else {
    if (told_ && !told_by_user_) count_from(all_, times, path);
    told_ = true;
  }
  if (!begun_) {
    all_ = std::move(times);
  } else {
    all_.values.insert(all_.values.end(), times.values.begin(), times.values.end());
    all_.guessed = all_.guessed || times.guessed;
  }
  begun_ = true;
}

void NetcdfClock::describe(SeriesDescription& d) const {
  if (untold_.empty() && all_.guessed && !rise(all_.values)) {
    if (!told_by_user_)
      d.warnings.push_back(concat(all_.origin,
                                  " does not rise from frame to frame and is taken for no time: ",
                                  "frames are counted; --dt or --times sets their times"));
  } else if (untold_.empty()) {
    d.times = {all_.values, all_.unit, all_.origin};
    if (!all_.epoch.empty()) d.attributes.emplace_back("time_epoch", all_.epoch);
    if (!all_.calendar.empty()) d.attributes.emplace_back("time_calendar", all_.calendar);
  } else if (!told_by_user_ && !all_.unread.empty()) {
    d.warnings.push_back(concat("the times of ", untold_, " are not read (", all_.unread,
                                "): frames are counted; --dt or --times sets their times"));
  } else if (!told_by_user_ && told_) {
    d.warnings.push_back(concat(untold_, " does not tell the times of its frames, as others do: frames are ",
                                "counted; --dt or --times sets their times"));
  }
}

} // namespace bcc4
