// SPDX-License-Identifier: Apache-2.0
#include "tool/view/dates.h"

namespace bcc4 {

Dates::Dates(const Volume& volume) : clock_(clock_of(volume)) {
  calendar_ = calendar_by_name(clock_.calendar);
  epoch_ = parse_date(clock_.epoch);
}

std::string Dates::of(double time) const {
  if (!known()) return "";
  const auto date = date_after(*epoch_, time, clock_.unit, *calendar_);
  return date ? date_text(*date) : "";
}

} // namespace bcc4
