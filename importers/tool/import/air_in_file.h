// SPDX-License-Identifier: Apache-2.0
// The air of a file's channels as the source had it.
#pragma once

#include <map>
#include <string>

#include "tool/handles.h"

namespace bcc4 {

// The attribute that tells the air of a channel where no float is it.
[[nodiscard]] inline std::string air_attribute(const std::string& channel) { return "import.air." + channel; }
// A series that is appended to keeps the air it has: that of every channel of a file.
[[nodiscard]] std::map<std::string, double> air_in_file(const Volume& volume);

} // namespace bcc4
