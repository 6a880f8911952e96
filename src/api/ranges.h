// SPDX-License-Identifier: Apache-2.0
// Byte ranges as calls of the C ABI take and give them.
#pragma once

#include <cstdint>
#include <span>

#include "base/files.h"

namespace bccsplat::api {

// Fails with invalid_argument.
void check_ranges(uint32_t flags, const uint64_t* ranges, uint64_t capacity);
// Writes the first `capacity` ones, and how many there are unless count is null.
void write_ranges(std::span<const ByteRange> found, uint64_t* ranges, uint64_t capacity, uint64_t* count);

} // namespace bccsplat::api
