// SPDX-License-Identifier: Apache-2.0
// Types of source values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "base/half.h"

namespace bccsplat::series {

// 64-bit integers are widened to f64 by the readers: no reader hands them out.
enum class Type : uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64 };

// Bits of an IEEE 754 binary16.
struct Half {
  uint16_t bits;
};
[[nodiscard]] inline bool is_float(Type type) { return type >= Type::f16; }

// Calls f with a value of the C++ type: visit_type(type, [](auto zero) { using T = decltype(zero); ... }).
template<class F> decltype(auto) visit_type(Type type, F&& f) {
  switch (type) {
  case Type::u8:
    return f(uint8_t{});
  case Type::i8:
    return f(int8_t{});
  case Type::u16:
    return f(uint16_t{});
  case Type::i16:
    return f(int16_t{});
  case Type::u32:
    return f(uint32_t{});
  case Type::i32:
    return f(int32_t{});
  case Type::u64:
    return f(uint64_t{});
  case Type::i64:
    return f(int64_t{});
  case Type::f16:
    return f(Half{});
  case Type::f32:
    return f(float{});
  case Type::f64:
    break;
  }
  return f(double{});
}

[[nodiscard]] inline size_t type_size(Type type) {
  return visit_type(type, [](auto zero) { return sizeof zero; });
}

template<class T> [[nodiscard]] double load_as(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  if constexpr (std::is_same_v<T, Half>)
    return half_to_float(value.bits);
  else
    return static_cast<double>(value);
}

} // namespace bccsplat::series
