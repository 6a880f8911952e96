// SPDX-License-Identifier: Apache-2.0
// What is tried where a file has missed the PSNR that a sample of its series promised.
#pragma once

#include <cstddef>
#include <vector>

#include "choose/series_writer.h"

namespace bccsplat::series {

// Has samples corrected that keep a channel from the PSNR of the settings: of each channel by its own range.
void correct_for_psnr(WriterSettings& settings, const std::vector<ChannelScan>& scans);

// Makes the settings finer for another attempt and says how, "finer steps" or "corrections"; null: nothing is
// left that would help. missed: attempts before. scans: of the whole series.
[[nodiscard]] const char* make_finer(const SeriesDescription& series, const std::vector<ChannelScan>& scans,
                                     size_t missed, WriterSettings& settings);

} // namespace bccsplat::series
