// SPDX-License-Identifier: Apache-2.0
#include "tool/output/export_type.h"

#include <array>

namespace bcc4 {

Type export_type(const bccsplat_channel_info& channel) {
  switch (channel.source_type) {
  case BCCSPLAT_TYPE_U8:
    return Type::u8;
  case BCCSPLAT_TYPE_I8:
    return Type::i8;
  case BCCSPLAT_TYPE_U16:
    return Type::u16;
  case BCCSPLAT_TYPE_I16:
    return Type::i16;
  default:
    return Type::f32;
  }
}

double exported_value(Type type, float value) {
  return visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 2)) {
      std::array<std::byte, sizeof(T)> bytes;
      store_as<T>(static_cast<double>(value), bytes.data());
      return load_as<T>(bytes.data());
    } else {
      return static_cast<double>(value);
    }
  });
}

} // namespace bcc4
