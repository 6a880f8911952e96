// SPDX-License-Identifier: Apache-2.0
// The value of empty space where the source does not say it: 0, or for dense data of floats a value among
// theirs. The nearer values are to air, the less a constant among them ripples.
#pragma once

#include <map>
#include <set>
#include <string>

#include "choose/series_writer.h"
#include "series/frame_reader.h"
#include "series/watch.h"

namespace bccsplat::series {

// Air of the channels of floats of whose first frame hardly a sample is the air they would have: the smallest
// value where a fourth of the samples are just that; else their mean, where it is further from that air than
// half of their standard deviation. Reads that frame; a series that goes on later has the same. said: the
// channels that need none.
[[nodiscard]] std::map<std::string, double> dense_air(FrameReader& reader, const WriterSettings& settings,
                                                      const std::set<std::string>& said, Watch& watch);

} // namespace bccsplat::series
