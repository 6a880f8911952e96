// SPDX-License-Identifier: Apache-2.0
// A part of a series, imported by a process of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "series/scan.h"

namespace bccsplat::series {

// Frames first .. end - 1.
struct FrameSpan {
  uint64_t first = 0, end = 0;
};
// Frames before `first` back to one that is there in every channel. scans: by channel.
[[nodiscard]] uint64_t lead_of(const std::vector<ChannelScan>& scans, uint64_t first);

} // namespace bccsplat::series
