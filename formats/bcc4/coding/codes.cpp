// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/codes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/half.h"

namespace bccsplat {

SampleCoder::SampleCoder(const Quantiser& q, float zero)
    : scale_(q.scale), bias_(q.offset - zero), zero_(zero) {
  codes_.type = q.type;
  uint64_t clamped = 0;
  codes_.air = encode(0, clamped);
  if (is_float(codes_.type)) return;
  const auto scale = static_cast<float>(scale_), bias = static_cast<float>(bias_);
  is_single_ = true;
  for (uint32_t code = 0; code <= codes_.mask() && is_single_; ++code) {
    const float scaled = static_cast<float>(code) * scale;
    is_single_ = scaled + bias == decode(code);
  }
}

uint32_t SampleCoder::encode(float relative, uint64_t& clamped) const {
  switch (codes_.type) {
  case ValueType::u8:
  case ValueType::u16: {
    const double stored = std::floor((relative - bias_) / scale_ + 0.5);
    const double kept = std::clamp<double>(stored, 0, codes_.mask());
    if (stored != kept) ++clamped;
    return static_cast<uint32_t>(kept);
  }
  case ValueType::f16: {
    uint16_t half = float_to_half(static_cast<float>(relative - bias_));
    if ((half & 0x7fff) >= 0x7c00) {
      ++clamped;
      half = static_cast<uint16_t>((half & 0x8000) | 0x7bff);
    }
    return code_of(half, codes_);
  }
  case ValueType::f32:
    break;
  }
  return code_of(std::bit_cast<uint32_t>(bias_ == 0 ? relative : static_cast<float>(relative - bias_)),
                 codes_);
}

float SampleCoder::decode(uint32_t code) const {
  switch (codes_.type) {
  case ValueType::u8:
  case ValueType::u16:
    return static_cast<float>(code * scale_ + bias_);
  case ValueType::f16: {
    const float half = half_to_float(static_cast<uint16_t>(pattern_of(code, codes_)));
    return bias_ == 0 ? half : static_cast<float>(half + bias_);
  }
  case ValueType::f32:
    break;
  }
  const auto stored = std::bit_cast<float>(pattern_of(code, codes_));
  return bias_ == 0 ? stored : static_cast<float>(stored + bias_);
}

uint32_t SampleCoder::lowest() const {
  switch (codes_.type) {
  case ValueType::f16:
    return code_of(0xfbff, codes_);
  case ValueType::f32:
    return code_of(0xff7fffff, codes_);
  default:
    return 0;
  }
}

} // namespace bccsplat
