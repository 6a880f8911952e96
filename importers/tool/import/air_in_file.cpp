// SPDX-License-Identifier: Apache-2.0
#include "tool/import/air_in_file.h"

#include "readers/text.h"

namespace bcc4 {

std::map<std::string, double> air_in_file(const Volume& volume) {
  std::map<std::string, double> air;
  for (uint32_t c = 0; c < volume_info(volume).channel_count; ++c) {
    const bccsplat_channel_info info = channel_info(volume, c);
    air[info.name] = info.air;
    const char* source = nullptr;
    if (bccsplat_volume_find_attribute(volume.get(), air_attribute(info.name).c_str(), &source) !=
        BCCSPLAT_OK)
      continue;
    const auto known = parse_number<double>(source);
    if (known && static_cast<float>(*known) == static_cast<float>(info.air)) air[info.name] = *known;
  }
  return air;
}

} // namespace bcc4
