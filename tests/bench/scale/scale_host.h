// SPDX-License-Identifier: Apache-2.0
// A host of the C API for the suite `scale`: a series of puffs of smoke of any size, written frame by frame
// without ever being held, and pictures of it.
#pragma once

#include <cstdint>
#include <string>

#include "tests/support/api_handles.h"

namespace bccsplat::bench {

using host::Handle;

// Throws Error with the library's text unless the status is OK.
void api(bccsplat_status status);

[[nodiscard]] Handle<bccsplat_device> make_api_device(int threads);

// n^3 x frames samples of u8: eight puffs, each 3n/8 wide and moving through its own octant, in air 0.
struct Puffs {
  uint32_t n = 64, frames = 16;
  [[nodiscard]] double samples() const { return 1.0 * n * n * n * frames; }
};

// Writes `path` anew; the report's bytes and counts.
bccsplat_writer_report write_puffs(bccsplat_device* device, const Puffs& puffs, const std::string& path);
[[nodiscard]] Handle<bccsplat_volume> open_puffs(bccsplat_device* device, const std::string& path);
[[nodiscard]] Handle<bccsplat_slice> slice_puffs(const bccsplat_volume* volume, double frame);
// One shaded picture of the slice, size x size.
bccsplat_render_stats draw_puffs(bccsplat_device* device, const bccsplat_slice* slice, uint32_t size);

[[nodiscard]] bccsplat_volume_info info_of(const bccsplat_volume* volume);
[[nodiscard]] bccsplat_slice_info info_of(const bccsplat_slice* slice);
// Has the system drop what it caches of a file, where it can: the next reader waits for the disk.
void forget_pages(const std::string& path);
// Bytes the device's objects held at most.
[[nodiscard]] uint64_t peak_of(const bccsplat_device* device);

} // namespace bccsplat::bench
