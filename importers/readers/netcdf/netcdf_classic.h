// SPDX-License-Identifier: Apache-2.0
// Classic NetCDF files that were cut off: the library reads what lies beyond the end of a file as zeros, so
// they must be found by their size.
#pragma once

#include <cstdint>
#include <vector>

#include "readers/netcdf/netcdf_file.h"

namespace bcc4 {

// Returns the bytes that a classic file holds at the very least, of the open file `id` with these variables;
// 0 for a file of NetCDF-4, which tells itself that it was cut off.
[[nodiscard]] uint64_t least_classic_bytes(int id, const std::vector<NetcdfVariable>& variables);

} // namespace bcc4
