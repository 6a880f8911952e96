// SPDX-License-Identifier: Apache-2.0
#include "tool/output/export_type.h"

#include <array>
#include <cmath>

namespace bcc4 {

Type export_type(const bccsplat_channel_info& channel) {
  constexpr double exact = 1 << 24; // whole numbers up to this are, as floats
  const auto below = [](const double(&range)[2]) {
    return std::abs(range[0]) <= exact && std::abs(range[1]) <= exact;
  };
  const bool complete = channel.holes == 0 && channel.missing == 0; // floats have a code for what is missing
  const bool whole = complete && below(channel.range) && below(channel.kept_range);
  switch (channel.source_type) {
  case BCCSPLAT_TYPE_U8:
    return Type::u8;
  case BCCSPLAT_TYPE_I8:
    return Type::i8;
  case BCCSPLAT_TYPE_U16:
    return Type::u16;
  case BCCSPLAT_TYPE_I16:
    return Type::i16;
  case BCCSPLAT_TYPE_I32:
    return whole ? Type::i32 : Type::f32;
  case BCCSPLAT_TYPE_U32:
    return whole ? Type::u32 : Type::f32;
  default:
    return Type::f32;
  }
}

double exported_value(Type type, float value) {
  return visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 4)) {
      std::array<std::byte, sizeof(T)> bytes;
      store_as<T>(static_cast<double>(value), bytes.data());
      return load_as<T>(bytes.data());
    } else {
      return static_cast<double>(value);
    }
  });
}

} // namespace bcc4
