// SPDX-License-Identifier: Apache-2.0
// Times that files of one frame each tell of their own.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "readers/frame_reader.h"

namespace bcc4 {

struct FileTime {
  std::optional<double> time;
  std::string unit;
};

// Takes the times of the files for those of the series, with the first one's unit, where every file has a
// time of one unit and they rise; a note says why where only that is amiss. `key` is what the format calls
// them.
void take_file_times(SeriesDescription& series, std::span<const FileTime> files, const std::string& key);

} // namespace bcc4
