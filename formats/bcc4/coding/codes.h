// SPDX-License-Identifier: Apache-2.0
// Turns samples of one channel into codes and back (bcc4.md, section 6).
//
// Samples are relative to air, or to another value where a reader wants that. Ordered codes are unsigned
// integers that rise with the value: stored integers as they are, the bit patterns of floats with the sign
// folded in.
#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/bcc4/coding/chunk.h"
#include "points/values.h"

namespace bccsplat {

class SampleCoder {
 public:
  explicit SampleCoder(const Quantiser& q) : SampleCoder(q, q.air) {}
  // Codes values relative to `zero` in place of air.
  SampleCoder(const Quantiser& q, float zero);

  [[nodiscard]] const ChunkCodes& codes() const { return codes_; }
  // The nearest code, halves upwards for integers, of a finite value; `clamped` counts values outside the
  // type.
  [[nodiscard]] uint32_t encode(float relative, uint64_t& clamped) const;
  [[nodiscard]] float decode(uint32_t code) const;
  // Returns whether an integer's value is what single precision makes of stored * scale + bias, step by step,
  // for all there are of this type.
  [[nodiscard]] bool is_single() const { return is_single_; }
  // relative = stored * scale + bias, in double precision.
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double bias() const { return bias_; }
  // The value in the units of the channel, not relative to anything.
  [[nodiscard]] double value(uint32_t code) const { return decode(code) + zero_; }
  // The lowest and the highest code of a finite value.
  [[nodiscard]] uint32_t lowest() const;
  [[nodiscard]] uint32_t highest() const { return codes_.mask() - lowest(); }

 private:
  ChunkCodes codes_;
  double scale_, bias_, zero_;
  bool is_single_ = false;
};

// The bit pattern of an ordered code and the reverse.
[[nodiscard]] inline uint32_t pattern_of(uint32_t code, const ChunkCodes& codes) {
  if (!is_float(codes.type)) return code;
  const uint32_t sign = codes.mask() / 2 + 1;
  return (code & sign ? code ^ sign : ~code) & codes.mask();
}
[[nodiscard]] inline uint32_t code_of(uint32_t pattern, const ChunkCodes& codes) {
  if (!is_float(codes.type)) return pattern;
  const uint32_t sign = codes.mask() / 2 + 1;
  return (pattern & sign ? ~pattern : pattern ^ sign) & codes.mask();
}

} // namespace bccsplat
