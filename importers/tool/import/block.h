// SPDX-License-Identifier: Apache-2.0
// Series imported in blocks of space: of frames larger than memory, or by many processes.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tool/import/write_series.h"

namespace bcc4 {

// Reads "X0:X1,Y0:Y1,Z0:Z1", samples X0 .. X1 - 1 and so on; a part that is empty means all of its axis.
[[nodiscard]] SampleBox parse_block(const std::string& text, const std::array<uint64_t, 4>& dims);

// Reads "K/N": the K-th of N boxes of nearly equal size, K from 1; none where the text is of another form.
[[nodiscard]] std::optional<SampleBox> parse_block_number(const std::string& text,
                                                          const std::array<uint64_t, 4>& dims);

// Returns what was asked for that whole frames are needed for, in words; "" for nothing.
[[nodiscard]] std::string needs_whole_frames(const WriterSettings& settings);
// Settles what blocks need: samples where no store was asked for, predictions of fixed boldness, all measured
// or nothing.
void settle_for_blocks(WriterSettings& settings);

// Returns the bytes that importing whole frames takes at most, by what was measured
// (tests/bench/notes/blocks.md).
[[nodiscard]] uint64_t memory_of_frames(const SeriesDescription& series, const WriterSettings& settings);

// Returns boxes that share the samples of a series among them, each so small that importing it takes no more
// than `memory` bytes by what was measured; one where all fits.
[[nodiscard]] std::vector<SampleBox> blocks_that_fit(const Device& device, const SeriesDescription& series,
                                                     const WriterSettings& settings, uint64_t memory);

// Writes the series block by block, each into a file beside the output that goes when all are joined. When
// they miss the PSNR that a sample has promised, all are written again, as write_series does.
[[nodiscard]] ImportResult write_blocks(FrameReader& reader, const Device& device,
                                        std::vector<WriterSettings>& attempts, const ImportScope& scope,
                                        const CommonOptions& common, const std::vector<SampleBox>& blocks);

} // namespace bcc4
