// SPDX-License-Identifier: Apache-2.0
// Names of types, and values as bytes of files.
#pragma once

#include <bit>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "series/value_type.h"

namespace bcc4 {

using namespace bccsplat::series; // what readers and the core know of a series, by one set of words

[[nodiscard]] const char* type_name(Type type);
// Finds a type by our names (u8, f32) and the usual ones of C and NRRD (uchar, unsigned short, uint16_t,
// float, double ...).
[[nodiscard]] std::optional<Type> type_by_name(std::string_view name);

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
