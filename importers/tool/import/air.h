// SPDX-License-Identifier: Apache-2.0
// The value of empty space where the source does not say it: 0, or for dense data of floats a value among
// theirs. The nearer values are to air, the less a constant among them ripples.
#pragma once

#include <map>
#include <string>

#include "readers/frame_reader.h"
#include "tool/import/series_writer.h"

namespace bcc4 {

// Air of the channels of floats that are dense and far from the air they would have: hardly a sample of the
// first frame is air, and their mean is further from it than half of their standard deviation. Reads that
// frame; a series that goes on later has the same.
[[nodiscard]] std::map<std::string, double> dense_air(FrameReader& reader, const WriterSettings& settings);

// A series that is appended to keeps the air it has: that of every channel of a file.
[[nodiscard]] std::map<std::string, double> air_in_file(const Device& device, const std::string& path);

} // namespace bcc4
