// SPDX-License-Identifier: Apache-2.0
// NetCDF files by the CF conventions: the one file of the tool's own that knows libnetcdf (its module
// writes).
#pragma once

#include <memory>
#include <string>

#include "tool/output/volume_file.h"

namespace bcc4 {

// Throws for axes that run along none of the world's: coordinate variables cannot tell of them.
void require_netcdf_axes(const VolumeOutput& output, const std::string& name);
// Writes to `path`; `name` is what errors call the file. Whoever calls takes away what is not finished.
[[nodiscard]] std::unique_ptr<VolumeFile> create_netcdf(const std::string& path, const std::string& name,
                                                        const VolumeOutput& output);

} // namespace bcc4
