// SPDX-License-Identifier: Apache-2.0
// Names of types as they are met in headers and on the command line, and conversions between values and
// bytes.
#include "readers/value_type.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "readers/text.h"

namespace bcc4 {
namespace {

struct TypeName {
  const char* name;
  Type type;
};
// The first entry of a type is the name we print.
constexpr TypeName kNames[] = {
    {"u8", Type::u8},
    {"i8", Type::i8},
    {"u16", Type::u16},
    {"i16", Type::i16},
    {"u32", Type::u32},
    {"i32", Type::i32},
    {"u64", Type::u64},
    {"i64", Type::i64},
    {"f16", Type::f16},
    {"f32", Type::f32},
    {"f64", Type::f64},
    {"uchar", Type::u8},
    {"unsigned char", Type::u8},
    {"uint8", Type::u8},
    {"uint8_t", Type::u8},
    {"signed char", Type::i8},
    {"int8", Type::i8},
    {"int8_t", Type::i8},
    {"ushort", Type::u16},
    {"unsigned short", Type::u16},
    {"unsigned short int", Type::u16},
    {"uint16", Type::u16},
    {"uint16_t", Type::u16},
    {"short", Type::i16},
    {"short int", Type::i16},
    {"signed short", Type::i16},
    {"signed short int", Type::i16},
    {"int16", Type::i16},
    {"int16_t", Type::i16},
    {"uint", Type::u32},
    {"unsigned int", Type::u32},
    {"uint32", Type::u32},
    {"uint32_t", Type::u32},
    {"int", Type::i32},
    {"signed int", Type::i32},
    {"int32", Type::i32},
    {"int32_t", Type::i32},
    {"ulonglong", Type::u64},
    {"unsigned long long", Type::u64},
    {"unsigned long long int", Type::u64},
    {"uint64", Type::u64},
    {"uint64_t", Type::u64},
    {"longlong", Type::i64},
    {"long long", Type::i64},
    {"long long int", Type::i64},
    {"signed long long", Type::i64},
    {"signed long long int", Type::i64},
    {"int64", Type::i64},
    {"int64_t", Type::i64},
    {"half", Type::f16},
    {"float16", Type::f16},
    {"float", Type::f32},
    {"float32", Type::f32},
    {"double", Type::f64},
    {"float64", Type::f64},
};

template<size_t N> void swap_elements(std::span<std::byte> bytes) {
  for (size_t i = 0; i + N <= bytes.size(); i += N) std::reverse(bytes.data() + i, bytes.data() + i + N);
}

} // namespace

const char* type_name(Type type) {
  return std::find_if(std::begin(kNames), std::end(kNames), [&](const TypeName& n) { return n.type == type; })
      ->name;
}

std::optional<Type> type_by_name(std::string_view name) {
  const std::string wanted = lower(trim(name));
  for (const TypeName& entry : kNames)
    if (wanted == entry.name) return entry.type;
  return std::nullopt;
}

template<class T> void store_as(double value, std::byte* at) {
  T stored;
  if constexpr (std::is_floating_point_v<T>) {
    stored = static_cast<T>(value);
  } else {
    constexpr double lowest = std::numeric_limits<T>::lowest();
    constexpr double highest = std::numeric_limits<T>::max();
    stored = std::isnan(value) ? T{0} : static_cast<T>(std::clamp(std::nearbyint(value), lowest, highest));
  }
  std::memcpy(at, &stored, sizeof stored);
}
template void store_as<uint8_t>(double, std::byte*);
template void store_as<int8_t>(double, std::byte*);
template void store_as<uint16_t>(double, std::byte*);
template void store_as<int16_t>(double, std::byte*);
template void store_as<uint32_t>(double, std::byte*);
template void store_as<int32_t>(double, std::byte*);
template void store_as<float>(double, std::byte*);
template void store_as<double>(double, std::byte*);

void widen_values(std::span<std::byte> values, Type type) {
  if (widened(type) == type) return;
  visit_type(type, [&](auto zero) {
    for (size_t i = 0; i + 8 <= values.size(); i += 8)
      store_as<double>(load_as<decltype(zero)>(values.data() + i), values.data() + i);
  });
}

void swap_bytes(std::span<std::byte> bytes, size_t size) {
  if (size == 2) swap_elements<2>(bytes);
  if (size == 4) swap_elements<4>(bytes);
  if (size == 8) swap_elements<8>(bytes);
}

} // namespace bcc4
