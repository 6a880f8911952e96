// SPDX-License-Identifier: Apache-2.0
// Rounds real values to those a file can hold. The fit hands out rounded values, so that what is kept, what
// is counted and what a reader gets back agree; the container's own rounding then changes nothing.
#pragma once

#include <cstdint>

#include "points/values.h"

namespace bccsplat {

// The largest code of an integer type; 0 for the other types.
[[nodiscard]] constexpr uint32_t largest_code(ValueType type) {
  return type == ValueType::u8 ? 255u : type == ValueType::u16 ? 65535u : 0u;
}
// The value of an integer code relative to air, as everyone computes it.
[[nodiscard]] inline float relative_value(const Quantiser& q, double code) {
  return static_cast<float>(code * q.scale + (q.offset - q.air));
}

// Holds every value of `source` in its own precision where a stored type has it: i8 and i16 by an offset,
// i32, u32 and f64 as f32.
[[nodiscard]] Quantiser quantiser_of_source(SourceType source, float air);
// Spreads [low, high] over the codes of u8 or u16; f16 and f32 hold values relative to air.
[[nodiscard]] Quantiser quantiser_of_range(ValueType type, const Range& range, float air);

} // namespace bccsplat
