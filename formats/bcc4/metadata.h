// SPDX-License-Identifier: Apache-2.0
// The metadata block: VolumeInfo as records (bcc4.md, section 3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/error.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/info.h"

namespace bccsplat {

// Checks the rules that hold from the first sample on; a broken one fails with `code`: invalid_argument for a
// caller's info, corrupt for a file's.
void check_fixed(const VolumeInfo& info, Code code);
// Checks what the values of a channel are, which is a part of that.
void check_channel(const ChannelInfo& c, Code code);
// Checks where the samples stand along unevenly spaced axes.
void check_axes(const VolumeInfo& info, Code code);
// Checks these and the rules for the rest: times, ranges, texts.
void check_info(const VolumeInfo& info, Code code);
// Mends what must not spoil a finished file: ranges of nothing become 0 .. 0, bytes that are no UTF-8 become
// the replacement character, and of attributes with one key only the last stays.
void tidy(VolumeInfo& info);

[[nodiscard]] std::vector<std::byte> write_metadata(const VolumeInfo& info);
// Reads an info, checks it, and refuses what exceeds `limits`. `offset` of the block is for error texts.
[[nodiscard]] VolumeInfo read_metadata(std::span<const std::byte> decoded, uint64_t offset,
                                       const Bcc4Limits& limits);

} // namespace bccsplat
