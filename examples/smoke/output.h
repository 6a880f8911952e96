// SPDX-License-Identifier: Apache-2.0
// Writes frames of a simulation: raw floats and OpenVDB.
#pragma once

#include <filesystem>

#include "smoke/grid.h"

namespace smoke {

// Returns FOLDER/NAME.0007.raw and so on.
std::filesystem::path frame_path(const std::filesystem::path& folder, const char* name, int frame,
                                 const char* extension);

// Writes bare little-endian float32, x fastest. Throws std::runtime_error.
void write_raw(const std::filesystem::path& path, const Grid& grid);

// Whether the program was built with OpenVDB.
extern const bool has_vdb;
// Writes a fog volume "density" with background 0 and voxels of edge `voxel` (world units); only voxels other
// than 0 are active; `half` stores 16-bit floats. Throws std::runtime_error.
void write_vdb(const std::filesystem::path& path, const Grid& grid, double voxel, bool half);

} // namespace smoke
