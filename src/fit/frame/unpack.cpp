// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/frame/unpack.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>
#include <cstring>
#include <type_traits>

#include "fit/frame/unpack.h"

// Plain loops that the compiler vectorises, once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

// What air is subtracted as.
template<class T>
using AirOf = std::conditional_t<sizeof(T) >= 4 && !std::is_same_v<T, float>, double, float>;

template<class T> HWY_INLINE float Relative(T value, AirOf<T> air) {
  return static_cast<float>(static_cast<AirOf<T>>(value) - air);
}

// binary16 in an integer: the value scaled by 2^-112 has the same bits in binary32.
struct Half {
  uint16_t bits;
};
HWY_INLINE float Relative(Half h, float air) {
  const uint32_t magnitude = h.bits & 0x7fffu;
  const float scaled = std::bit_cast<float>(magnitude << 13) * 0x1p112f;
  const uint32_t nonfinite = magnitude >= 0x7c00u ? 0x7f800000u : 0u;
  return std::bit_cast<float>(std::bit_cast<uint32_t>(scaled) | nonfinite | (h.bits & 0x8000u) << 16) - air;
}

template<class T>
HWY_NOINLINE void UnpackAs(const std::byte* HWY_RESTRICT data, int64_t stride, size_t count, double air_value,
                           float* HWY_RESTRICT out) {
  const auto air = static_cast<AirOf<T>>(air_value);
  if (stride == sizeof(T)) {
    for (size_t i = 0; i < count; ++i) {
      T value;
      std::memcpy(&value, data + i * sizeof(T), sizeof(T));
      out[i] = Relative(value, air);
    }
    return;
  }
  for (size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, data + static_cast<int64_t>(i) * stride, sizeof(T));
    out[i] = Relative(value, air);
  }
}

void Unpack(SourceType type, const std::byte* data, int64_t stride, size_t count, double air, float* out) {
  switch (type) {
  case SourceType::u8:
    return UnpackAs<uint8_t>(data, stride, count, air, out);
  case SourceType::i8:
    return UnpackAs<int8_t>(data, stride, count, air, out);
  case SourceType::u16:
    return UnpackAs<uint16_t>(data, stride, count, air, out);
  case SourceType::i16:
    return UnpackAs<int16_t>(data, stride, count, air, out);
  case SourceType::u32:
    return UnpackAs<uint32_t>(data, stride, count, air, out);
  case SourceType::i32:
    return UnpackAs<int32_t>(data, stride, count, air, out);
  case SourceType::f16:
    return UnpackAs<Half>(data, stride, count, air, out);
  case SourceType::f32:
    return UnpackAs<float>(data, stride, count, air, out);
  case SourceType::f64:
    return UnpackAs<double>(data, stride, count, air, out);
  case SourceType::unknown:
    break;
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Unpack);

size_t source_bytes(SourceType type) {
  switch (type) {
  case SourceType::u8:
  case SourceType::i8:
    return 1;
  case SourceType::u16:
  case SourceType::i16:
  case SourceType::f16:
    return 2;
  case SourceType::u32:
  case SourceType::i32:
  case SourceType::f32:
    return 4;
  case SourceType::f64:
    return 8;
  case SourceType::unknown:
    break;
  }
  return 0;
}

void unpack_row(SourceType type, const std::byte* data, int64_t stride, size_t count, double air,
                float* out) {
  HWY_DYNAMIC_DISPATCH(Unpack)(type, data, stride, count, air, out);
}

} // namespace bccsplat
#endif
