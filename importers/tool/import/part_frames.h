// SPDX-License-Identifier: Apache-2.0
// What the parts of a series are made of: more frames and samples than their own.
#pragma once

#include "readers/frame_reader.h"
#include "tool/import/writer_settings.h"

namespace bcc4 {

// Frames that a writer is to be given: of a part some more than its own.
[[nodiscard]] FrameSpan wanted_frames(const Writer& writer);
// Samples of each that it takes: of a block its own and a few around them.
[[nodiscard]] SampleBox wanted_box(const Writer& writer);
// Frames that a part is made of.
[[nodiscard]] FrameSpan part_frames(const Device& device, const SeriesDescription& series,
                                    const WriterSettings& settings, const FrameSpan& part);
// Samples that a block of all frames is made of.
[[nodiscard]] SampleBox block_samples(const Device& device, const SeriesDescription& series,
                                      const WriterSettings& settings, const SampleBox& block);

} // namespace bcc4
