// SPDX-License-Identifier: Apache-2.0
// Types of source values.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace bcc4 {

// 64-bit integers are widened to f64 by the readers: no reader hands them out.
enum class Type : uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64 };

// Bits of an IEEE 754 binary16.
struct Half {
  uint16_t bits;
};
[[nodiscard]] float to_float(Half half);

[[nodiscard]] size_t type_size(Type type);
[[nodiscard]] const char* type_name(Type type);
// Finds a type by our names (u8, f32) and the usual ones of C and NRRD (uchar, unsigned short, uint16_t,
// float, double ...).
[[nodiscard]] std::optional<Type> type_by_name(std::string_view name);
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

template<class T> [[nodiscard]] double load_as(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  if constexpr (std::is_same_v<T, Half>)
    return to_float(value);
  else
    return static_cast<double>(value);
}

// Writes `value` as T: integers rounded to nearest and clamped, NaN as 0.
template<class T> void store_as(double value, std::byte* at);

// Returns the type handed out: f64 for 64-bit integers, others as they are.
[[nodiscard]] inline Type widened(Type type) {
  return type == Type::i64 || type == Type::u64 ? Type::f64 : type;
}
void widen_values(std::span<std::byte> values, Type type);

// Returns whether values of that byte order must be swapped on this machine.
[[nodiscard]] inline bool needs_swap(bool big_endian) {
  return big_endian != (std::endian::native == std::endian::big);
}
// Reverses the bytes of each element of `size` bytes.
void swap_bytes(std::span<std::byte> bytes, size_t size);

} // namespace bcc4
