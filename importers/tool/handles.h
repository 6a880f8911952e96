// SPDX-License-Identifier: Apache-2.0
// Devices and volumes of the tool, and what it says where the library refuses something.
#pragma once

#include <array>

#include "readers/clock.h"
#include "readers/error.h"
#include "series/library.h"

namespace bcc4 {

using bccsplat::client::Renderer;
using Image = bccsplat::client::Frame;
using bccsplat::series::check;
using bccsplat::series::Device;
using bccsplat::series::lattice_name;
using bccsplat::series::sized;
using bccsplat::series::Slice;
using bccsplat::series::Volume;
using bccsplat::series::Writer;

// Returns what to try after a call has failed so, as the end of a sentence; "" where nothing is known.
[[nodiscard]] const char* advice_on(Code code);
// INVALID_ARGUMENT and the like about a kernel name get the nearest one.
// Throws it if the code says that there is no such kernel.
void refuse_kernel(Code code, const std::string& kernel);
void check_kernel(bccsplat_status status, const std::string& what, const std::string& kernel);

[[nodiscard]] Device create_device(int threads, uint64_t memory_budget);
// `kernel` empty: the file's.
// shape: factors on the axes of the world; all 0: as stored.
[[nodiscard]] Volume open_volume(const Device& device, const std::string& path, const std::string& kernel,
                                 const std::array<double, 3>& shape = {});
[[nodiscard]] bccsplat_volume_info volume_info(const Volume& volume);
// The last frame index that can be looked at: of a periodic series that of frame 0 again.
[[nodiscard]] inline double last_index(const bccsplat_volume_info& v) {
  return static_cast<double>(v.dims[3]) - (v.time_periodic ? 0 : 1);
}
[[nodiscard]] bccsplat_channel_info channel_info(const Volume& volume, uint32_t channel);
// Where the samples stand along an axis of space; coordinates and unit belong to the volume.
[[nodiscard]] bccsplat_axis axis_info(const Volume& volume, uint32_t axis);
[[nodiscard]] bool has_coordinates(const Volume& volume);
// Returns the units along x, y and z of the world; "": not told.
[[nodiscard]] std::array<std::string, 3> axis_units(const Volume& volume);
// Returns an attribute; "" where there is none.
[[nodiscard]] std::string told(const Volume& volume, const char* key);
// Returns what its times mean.
[[nodiscard]] Clock clock_of(const Volume& volume);
[[nodiscard]] bccsplat_level_info level_info(const Volume& volume, uint32_t level);
// Finds a channel by its name or number.
[[nodiscard]] uint32_t find_channel(const Volume& volume, const std::string& name);

[[nodiscard]] const char* value_type_name(int32_t type);

} // namespace bcc4
