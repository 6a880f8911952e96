// SPDX-License-Identifier: Apache-2.0
#include "tool/import/air_in_file.h"

#include "readers/text.h"

namespace bcc4 {

void adopt_air(const Volume& old, const SeriesDescription& series, WriterSettings& settings) {
  for (uint32_t c = 0; c < volume_info(old).channel_count; ++c) {
    const bccsplat_channel_info info = channel_info(old, c);
    double air = info.air;
    const auto known = parse_number<double>(told(old, air_attribute(info.name).c_str()));
    if (known && static_cast<float>(*known) == static_cast<float>(air)) air = *known;
    for (size_t s = 0; s < settings.values.size(); ++s)
      if (series.channels[s].name == info.name)
        settings.values[s].air = air, settings.values[s].set_mask |= BCCSPLAT_CHANNEL_SET_AIR;
  }
}

} // namespace bcc4
