// SPDX-License-Identifier: Apache-2.0
// What numbers of time mean: units since a date of a calendar. All who bring times of two series together
// ask here.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "readers/frame_reader.h"

namespace bcc4 {

// What is not told is empty.
struct Clock {
  std::string unit, epoch, calendar; // epoch: the date of 0
};

[[nodiscard]] Clock clock_of(const SeriesDescription& series);

// Returns text such as "days since 1970-01-01, calendar noleap".
[[nodiscard]] std::string clock_text(const Clock& clock);

// Returns the two as far as both tell: a unit or a date that only one has is that of the other, too.
[[nodiscard]] std::pair<Clock, Clock> told_by_both(Clock a, Clock b);

// The time of another clock, in whose numbers time is scale x time + offset; the call rounds least.
struct ClockChange {
  double unit = 1, apart = 0, other_unit = 1; // seconds
  [[nodiscard]] double operator()(double time) const { return (time * unit + apart) / other_unit; }
  [[nodiscard]] double scale() const { return unit / other_unit; }
  [[nodiscard]] double offset() const { return apart / other_unit; }
};
// Returns how times of one clock become those of another of the same calendar; nothing where that is not
// known.
[[nodiscard]] std::optional<ClockChange> clock_change(const Clock& from, const Clock& to);

// Turns times of one clock into those of another, by date where their calendars differ: days that the other
// calendar lacks become NaN. Returns false where it is not known how.
[[nodiscard]] bool convert_times(std::vector<double>& times, const Clock& from, const Clock& to);

} // namespace bcc4
