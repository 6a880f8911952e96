// SPDX-License-Identifier: Apache-2.0
// NetCDF, classic and 4, through libnetcdf.
#pragma once

#include <memory>
#include <string>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// Opens a variable of three spatial axes and time, any of which may be absent; --channel names variables,
// those of groups with the group (run1/f), without it the file must hold one candidate. Axes are known by the
// CF conventions (attribute axis, units, standard_name, positive), then by the names of dimensions, then by
// their place: time, z, y, x from slowest to fastest. Packed values and coordinates are unpacked;
// _FillValue, missing_value and valid_range mark holes. Files of a sequence are joined along time, each by
// its own scale, direction of axes and date of reference; what is at other places or in other units is
// refused.
[[nodiscard]] std::unique_ptr<FrameReader> open_netcdf(const Sequence& sequence,
                                                       const ReaderOptions& options);

} // namespace bcc4
