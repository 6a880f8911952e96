// SPDX-License-Identifier: Apache-2.0
// What 32-bit floats do not tell apart: the library reads wider values as such.
#pragma once

#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "series/watch.h"

namespace bcc4 {

// Returns a warning for each channel of 64-bit floats whose rounding would be seen, and of 32-bit integers
// that are not all exact as floats. Reads the first frame of such channels.
[[nodiscard]] std::vector<std::string> precision_warnings(FrameReader& reader, Watch& watch);

} // namespace bcc4
