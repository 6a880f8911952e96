// SPDX-License-Identifier: Apache-2.0
// Arithmetic coding of bits whose probabilities are known to both sides.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bccsplat {

inline constexpr int certain_bits = 16;
inline constexpr uint32_t certain = 1 << certain_bits; // a probability of 1
inline constexpr int top_byte = 24;

class BinaryEncoder {
 public:
  // `one` in 1 .. certain - 1: how likely it is that the bit is set.
  bool code(bool bit, uint32_t one) {
    const uint32_t middle = low_ + static_cast<uint32_t>((uint64_t{high_ - low_} * one) >> certain_bits);
    bit ? high_ = middle : low_ = middle + 1;
    while (((low_ ^ high_) >> top_byte) == 0) shift_out();
    return bit;
  }
  [[nodiscard]] std::vector<std::byte> finish() {
    bytes_.push_back(static_cast<std::byte>(high_ >> top_byte)); // a reader takes what is missing as zeros
    return std::move(bytes_);
  }

 private:
  void shift_out() {
    bytes_.push_back(static_cast<std::byte>(high_ >> top_byte));
    low_ <<= 8;
    high_ = high_ << 8 | 0xff;
  }
  uint32_t low_ = 0, high_ = UINT32_MAX;
  std::vector<std::byte> bytes_;
};

class BinaryDecoder {
 public:
  explicit BinaryDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next();
  }
  // The bit that was coded; the argument stands where the encoder has it.
  bool code(bool, uint32_t one) {
    const uint32_t middle = low_ + static_cast<uint32_t>((uint64_t{high_ - low_} * one) >> certain_bits);
    const bool bit = value_ <= middle;
    bit ? high_ = middle : low_ = middle + 1;
    while (((low_ ^ high_) >> top_byte) == 0) {
      low_ <<= 8;
      high_ = high_ << 8 | 0xff;
      value_ = value_ << 8 | next();
    }
    return bit;
  }

 private:
  uint32_t next() { return at_ < bytes_.size() ? static_cast<uint32_t>(bytes_[at_++]) : 0; }
  std::span<const std::byte> bytes_;
  size_t at_ = 0;
  uint32_t low_ = 0, high_ = UINT32_MAX, value_ = 0;
};

inline constexpr int most_rare_bits = 20; // also of a damaged number

// A number of 0 or more that is rarely large, in exponential Golomb code.
// length(bit, place) codes the bits that tell how many follow.
template<class Coder, class Length> int code_rare(Coder& coder, int number, const Length& length) {
  const int needed = std::bit_width(static_cast<uint32_t>(number) + 1) - 1;
  int bits = 0;
  while (bits < most_rare_bits && length(bits < needed, bits)) ++bits;
  int value = 1;
  for (int b = bits - 1; b >= 0; --b)
    value = value << 1 | (coder.code((number + 1) >> b & 1, certain / 2) ? 1 : 0);
  return value - 1;
}

} // namespace bccsplat
