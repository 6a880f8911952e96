// SPDX-License-Identifier: Apache-2.0
#include "choose/part.h"

#include <algorithm>

namespace bccsplat::series {

uint64_t lead_of(const std::vector<ChannelScan>& scans, uint64_t first) {
  const auto missing = [&](uint64_t frame) {
    return std::any_of(scans.begin(), scans.end(), [&](const ChannelScan& s) {
      return std::binary_search(s.missing.begin(), s.missing.end(), frame);
    });
  };
  uint64_t lead = 0;
  while (lead < first && missing(first - lead)) ++lead;
  return lead;
}

} // namespace bccsplat::series
