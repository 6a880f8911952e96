// SPDX-License-Identifier: Apache-2.0
// Rows of any numeric type as floats.
#pragma once

#include <cstddef>
#include <cstdint>

#include "points/values.h"

namespace bccsplat {

[[nodiscard]] size_t source_bytes(SourceType type); // of one sample; 0 for unknown
// Types whose values may not fit a float: these are subtracted from in double.
[[nodiscard]] constexpr bool wider_than_float(SourceType type) {
  return type == SourceType::i32 || type == SourceType::u32 || type == SourceType::f64;
}

// out[i] = sample i minus air, for `count` samples that are `stride` bytes apart (any alignment): so those
// that equal air are 0, though no float may be that air. From types that fit a float the nearest float is
// subtracted.
void unpack_row(SourceType type, const std::byte* data, int64_t stride, size_t count, double air, float* out);

} // namespace bccsplat
