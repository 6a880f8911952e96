// SPDX-License-Identifier: Apache-2.0
// Where the samples of a NetCDF variable lie, by the coordinate variables of its dimensions.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/netcdf/netcdf_file.h"

namespace bcc4 {

// One axis of space.
struct NetcdfLine {
  AxisRole role = AxisRole::x;
  std::string name; // of the dimension
  uint64_t size = 0;
  std::vector<double> at; // of the samples; empty where the file does not tell
  std::string unit;       // as the file says it
  bool down = false;      // `at` counts down
};

struct NetcdfSpace {
  std::vector<NetcdfLine> lines;        // in the order of the file's dimensions
  std::vector<std::string> curvilinear; // what tells places over two or more of the axes together
};
[[nodiscard]] NetcdfSpace netcdf_space(const NetcdfFile& file, const NetcdfVariable& v,
                                       const std::vector<AxisRole>& roles);

// Makes spacing and origin of the coordinates, in z with depths below 0. Uneven ones are kept, and the
// spacing is their mean; those that are not monotone are not, and a warning says so.
void describe_space(SeriesDescription& d, const NetcdfSpace& space);

// Returns which of x, y and z run the other way than in the first file. Throws, in the name of the file,
// where its samples are at other places; with `any_place` coordinates that this makes wrong are dropped from
// `d`, and a warning says so.
[[nodiscard]] std::array<bool, 3> turned_axes(SeriesDescription& d, const NetcdfSpace& first,
                                              const NetcdfSpace& space, const std::string& path,
                                              bool any_place);

} // namespace bcc4
