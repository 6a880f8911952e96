// SPDX-License-Identifier: Apache-2.0
// A part of a series, imported by a process of its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "readers/scan.h"

namespace bcc4 {

// Frames first .. end - 1.
struct FrameSpan {
  uint64_t first = 0, end = 0;
};
// "A-B" or "A": frames counted from 0; "K/N": the K-th of N parts of nearly equal length, K from 1.
[[nodiscard]] FrameSpan parse_part(const std::string& text, uint64_t frames);
// Frames before `first` back to one that is there in every channel. scans: by channel.
[[nodiscard]] uint64_t lead_of(const std::vector<ChannelScan>& scans, uint64_t first);

} // namespace bcc4
