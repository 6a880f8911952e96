// SPDX-License-Identifier: Apache-2.0
// Base64 as VTK writes it: runs one after the other, each padded by itself.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "readers/frame_reader.h"

namespace bcc4 {

// Takes one run (or as much of it as holds `bytes` bytes) off the front of `text`, white space ignored.
// Throws, naming `path`, for other characters and when the run is shorter.
[[nodiscard]] Bytes take_base64(std::string_view& text, uint64_t bytes, const std::string& path);

} // namespace bcc4
