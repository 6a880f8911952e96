// SPDX-License-Identifier: Apache-2.0
// The value of empty space where the source does not say it: 0, or for dense data of floats a value among
// theirs. The nearer values are to air, the less a constant among them ripples.
#pragma once

#include <map>
#include <string>

#include "readers/frame_reader.h"
#include "tool/import/series_writer.h"

namespace bcc4 {

// Air of the channels of floats of whose first frame hardly a sample is the air they would have: the smallest
// value where a fourth of the samples are just that; else their mean, where it is further from that air than
// half of their standard deviation. Reads that frame; a series that goes on later has the same.
[[nodiscard]] std::map<std::string, double> dense_air(FrameReader& reader, const WriterSettings& settings);

// The attribute that tells the air of a channel where no float is it.
[[nodiscard]] inline std::string air_attribute(const std::string& channel) { return "import.air." + channel; }
// A series that is appended to keeps the air it has: that of every channel of a file.
[[nodiscard]] std::map<std::string, double> air_in_file(const Device& device, const std::string& path);

} // namespace bcc4
