// SPDX-License-Identifier: Apache-2.0
// What the numbers of a NetCDF variable mean: sign, scaling and holes, by its attributes.
#pragma once

#include <string>
#include <vector>

#include "readers/netcdf/netcdf_file.h"
#include "readers/stored_values.h"

namespace bcc4 {

// Integers are without a sign, or with one, where _Unsigned says so, and so are those of attributes of the
// variable's own type. Packed are values that scale_factor and add_offset make of integers: attributes of
// floating point are then told of the values, others of what is stored (NetCDF user's guide, appendix A).
[[nodiscard]] StoredValues stored_values(const NetcdfFile& file, const NetcdfVariable& v);

// Returns the values of a coordinate variable, unpacked; NaN where it has its fill value.
[[nodiscard]] std::vector<double> coordinate_values(const NetcdfFile& file, const NetcdfVariable& v);

} // namespace bcc4
