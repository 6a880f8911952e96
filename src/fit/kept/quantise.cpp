// SPDX-License-Identifier: Apache-2.0
#include "fit/kept/quantise.h"

#include <cmath>

#include "base/error.h"

namespace bccsplat {

Quantiser quantiser_of_source(SourceType source, float air) {
  switch (source) {
  case SourceType::u8:
    return {ValueType::u8, 1, 0, air};
  case SourceType::i8:
    return {ValueType::u8, 1, -128, air};
  case SourceType::u16:
    return {ValueType::u16, 1, 0, air};
  case SourceType::i16:
    return {ValueType::u16, 1, -32768, air};
  case SourceType::f16:
    return {ValueType::f16, 1, 0, air};
  case SourceType::f32:
  case SourceType::i32:
  case SourceType::u32:
  case SourceType::f64:
    return {ValueType::f32, 1, air, air};
  case SourceType::unknown:
    break;
  }
  fail(Code::invalid_argument, "the type of the source values is not known");
}

Quantiser quantiser_of_range(ValueType type, const Range& range, float air) {
  if (type == ValueType::f16 || type == ValueType::f32) return {type, 1, air, air};
  if (!(std::isfinite(range.low) && std::isfinite(range.high) && range.low < range.high))
    fail(Code::invalid_argument, "the range ", range.low, " .. ", range.high,
         " cannot be spread over integers: it must be finite and rise");
  const Quantiser q{type, (range.high - range.low) / largest_code(type), range.low, air};
  if (std::fabs(air - q.offset) > 0x1p22 * q.scale)
    fail(Code::invalid_argument, "air ", air, " is too far from the range ", range.low, " .. ", range.high,
         " to store values as integers");
  return q;
}

} // namespace bccsplat
