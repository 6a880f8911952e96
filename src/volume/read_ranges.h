// SPDX-License-Identifier: Apache-2.0
// Which bytes of its file a cut reads.
#pragma once

#include <vector>

#include "volume/open_slice.h"

namespace bccsplat {

// Returns the ranges, rising and merged over small gaps; missing: those alone whose bytes are not held yet.
// kernel: as that of the request.
[[nodiscard]] std::vector<ByteRange> read_ranges(const OpenVolume& volume, const SliceRequest& asked,
                                                 const char* kernel, bool missing, const Context& context);

} // namespace bccsplat
