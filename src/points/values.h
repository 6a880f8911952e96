// SPDX-License-Identifier: Apache-2.0
// Types of samples, in a source and as they are stored, and ranges of values.
#pragma once

#include <cstdint>

namespace bccsplat {

// How samples are stored: as integers or as bit patterns of floats. The numbers are those of a .bcc4 file.
enum class ValueType : uint8_t { u8 = 1, u16 = 2, f16 = 3, f32 = 4 };
// Precision of the source, numbered as in a .bcc4 file.
enum class SourceType : uint8_t {
  unknown = 0,
  u8 = 1,
  u16 = 2,
  f16 = 3,
  f32 = 4,
  i16 = 5,
  i32 = 6,
  f64 = 7,
  i8 = 8,
  u32 = 9
};

[[nodiscard]] constexpr uint32_t value_bytes(ValueType type) {
  return type == ValueType::u8 ? 1 : type == ValueType::f32 ? 4 : 2;
}

[[nodiscard]] constexpr bool is_float(ValueType type) {
  return type == ValueType::f16 || type == ValueType::f32;
}

struct Range {
  double low = 0, high = 0; // closed
  bool operator==(const Range&) const = default;
};

// How values become what is stored: value = stored * scale + offset. Integers have scale > 0, and
// |air - offset| <= 2^22 scale, so that samples relative to air survive as floats. Floats
// have scale 1, and offset = air where samples are stored relative to air, as bricks hold them (f32: always,
// exact); f16 may have offset 0 to store the values themselves (exact for f16 sources).
struct Quantiser {
  ValueType type = ValueType::f32;
  double scale = 1, offset = 0;
  float air = 0; // value of sites that are not kept; bricks hold values relative to it
  bool operator==(const Quantiser&) const = default;
};

} // namespace bccsplat
