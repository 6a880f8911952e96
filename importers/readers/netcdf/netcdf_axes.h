// SPDX-License-Identifier: Apache-2.0
// Which dimension of a NetCDF variable is x, y, z and time.
#pragma once

#include <string>
#include <vector>

#include "readers/dense_series.h"
#include "readers/netcdf/netcdf_file.h"

namespace bcc4 {

struct NetcdfAxes {
  std::vector<AxisRole> roles; // of the variable's dimensions, slowest first
  std::string why;             // what the roles were known by
};

// `letters` is --axes, fastest first, or "". Throws when two dimensions claim one role or more than four are
// left.
[[nodiscard]] NetcdfAxes find_axes(const NetcdfFile& file, const NetcdfVariable& variable,
                                   const std::string& letters);

} // namespace bcc4
