// SPDX-License-Identifier: Apache-2.0
// Reads the frames of a series out of the NetCDF files that have been found to hold it.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/netcdf/netcdf_channels.h"
#include "readers/netcdf/netcdf_file.h"

namespace bcc4 {

// A file, which holds the frames first .. first + count - 1 of the series.
struct NetcdfPart {
  std::string path;
  uint64_t first = 0, count = 1;
  std::array<bool, 3> turned{}; // x, y, z: they run the other way than in the first file
};

// `roles` are those of the variables' dimensions, slowest first, and `file` is the first one, open.
[[nodiscard]] std::unique_ptr<FrameReader>
netcdf_frames(SeriesDescription description, std::vector<NetcdfChannel> channels, std::vector<AxisRole> roles,
              std::vector<NetcdfPart> parts, std::unique_ptr<NetcdfFile> file);

} // namespace bcc4
