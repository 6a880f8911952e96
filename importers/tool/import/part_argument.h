// SPDX-License-Identifier: Apache-2.0
// The part of a series that --part asks for.
#pragma once

#include <cstdint>
#include <string>

#include "readers/frame_reader.h"

namespace bcc4 {

// "A-B" or "A": frames counted from 0; "K/N": the K-th of N parts of nearly equal length, K from 1.
[[nodiscard]] FrameSpan parse_part(const std::string& text, uint64_t frames);

} // namespace bcc4
