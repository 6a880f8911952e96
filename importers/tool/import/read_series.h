// SPDX-License-Identifier: Apache-2.0
// Frames of a series from first to last, with a line of progress.
#pragma once

#include <functional>

#include "readers/frame_reader.h"
#include "tool/import/part.h"

namespace bcc4 {

using TakeFrame = std::function<void(uint64_t frame, uint32_t channel, const Frame& values)>;

// Reads the frames of a span, all channels of a frame one after the other, each while the one before is being
// taken. `label` begins the line of progress; shown: is there one?
void read_series(FrameReader& reader, const FrameSpan& span, const char* label, bool shown,
                 const TakeFrame& take);

} // namespace bcc4
