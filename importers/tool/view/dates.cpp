// SPDX-License-Identifier: Apache-2.0
#include "tool/view/dates.h"

namespace bcc4 {

Dates::Dates(const Volume& volume) : unit_(volume_info(volume).time_unit) {
  const char* text = nullptr;
  if (bccsplat_volume_find_attribute(volume.get(), "time_calendar", &text) == BCCSPLAT_OK) name_ = text;
  calendar_ = calendar_by_name(name_);
  if (bccsplat_volume_find_attribute(volume.get(), "time_epoch", &text) == BCCSPLAT_OK)
    epoch_ = parse_date(text);
}

std::string Dates::of(double time) const {
  if (!known()) return "";
  const auto date = date_after(*epoch_, time, unit_, *calendar_);
  return date ? date_text(*date) : "";
}

} // namespace bcc4
