// SPDX-License-Identifier: Apache-2.0
// The air of a file's channels as the source had it.
#pragma once

#include <string>

#include "tool/import/writer_settings.h"

namespace bcc4 {

// The attribute that tells the air of a channel where no float is it.
[[nodiscard]] inline std::string air_attribute(const std::string& channel) { return "import.air." + channel; }
// A series that is appended to keeps the air it has: that of every channel of a file.
void adopt_air(const Volume& old, const SeriesDescription& series, WriterSettings& settings);

} // namespace bcc4
