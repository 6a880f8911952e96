// SPDX-License-Identifier: Apache-2.0
// Times of a file as dates, where it tells the date of time 0 and a unit that calendars know.
#pragma once

#include <optional>
#include <string>

#include "readers/calendar.h"
#include "tool/handles.h"

namespace bcc4 {

class Dates {
 public:
  explicit Dates(const Volume& volume);
  // "" where the file tells none.
  [[nodiscard]] std::string of(double time) const;
  [[nodiscard]] bool known() const { return epoch_ && calendar_; }
  // As the file calls it; "" for the standard one.
  [[nodiscard]] const std::string& calendar() const { return clock_.calendar; }

 private:
  Clock clock_;
  std::optional<Date> epoch_;
  std::optional<Calendar> calendar_;
};

} // namespace bcc4
