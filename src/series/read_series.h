// SPDX-License-Identifier: Apache-2.0
// Frames of a series from first to last.
#pragma once

#include <functional>

#include "series/frame_reader.h"
#include "series/watch.h"

namespace bccsplat::series {

using TakeFrame = std::function<void(uint64_t frame, uint32_t channel, const Frame& values)>;

// Reads the frames of a span, all channels of a frame one after the other, each while the one before is being
// taken. label: of the work that is shown. wanted: the samples that are; null: all.
void read_series(FrameReader& reader, const FrameSpan& span, const char* label, Watch& watch,
                 const TakeFrame& take, const SampleBox* wanted = nullptr);

} // namespace bccsplat::series
