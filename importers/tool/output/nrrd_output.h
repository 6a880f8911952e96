// SPDX-License-Identifier: Apache-2.0
// Header text of attached NRRD files with raw little-endian data.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tool/output/volume_file.h"

namespace bcc4 {

// The keys that tell the time of a single frame, for which the format has no field; the reader takes them.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> time_keys(double time,
                                                                         const std::string& unit);
// Ends with the empty line after which the data begin.
[[nodiscard]] std::string nrrd_header_text(const VolumeOutput& output);

} // namespace bcc4
