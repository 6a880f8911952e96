// SPDX-License-Identifier: Apache-2.0
// A sum that does not depend on the order in which numbers are added: what processes have summed by
// themselves adds up to the sum of one of them, to the last bit.
//
// Numbers are rounded to 40 bits, which is all that is lost, and added as whole numbers to bins of eight
// exponents each. What a bin has beyond eight bits is carried to the next one, so that equal sums have equal
// bins.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"

namespace bccsplat {

class ExactSum {
 public:
  // value: not negative; what is less than 2^-1022 counts as 0.
  void add(double value) {
    const uint64_t bits = std::bit_cast<uint64_t>(value) + (uint64_t{1} << (dropped_bits - 1));
    const auto exponent = static_cast<int32_t>(bits >> fraction_bits);
    if (exponent == 0) return;
    const uint64_t whole = ((bits & fraction_mask) | (fraction_mask + 1)) >> dropped_bits;
    uint64_t& bin = bin_at(exponent / bin_exponents);
    bin += whole << (exponent % bin_exponents);
    if (bin >> full_bits != 0) carry();
  }
  // The same of many, at most most_at_once; quicker.
  static constexpr size_t most_at_once = 1024;
  void add(std::span<const double> values);
  void add(const ExactSum& other);
  // The nearest double, but for its last bits.
  [[nodiscard]] double value() const;

  void write(ByteWriter& out) const;
  // Throws truncated, corrupt.
  [[nodiscard]] static ExactSum read(ByteReader& in);

 private:
  static constexpr int fraction_bits = 52, dropped_bits = 13;
  static constexpr uint64_t fraction_mask = (uint64_t{1} << fraction_bits) - 1;
  static constexpr int bin_exponents = 8, all_bins = 2048 / bin_exponents;
  static constexpr int full_bits = 62; // a bin is carried before it overflows

  [[nodiscard]] uint64_t& bin_at(int32_t number) {
    const auto at = static_cast<size_t>(number - first_);
    return at < bins_.size() ? bins_[at] : new_bin(number);
  }
  [[nodiscard]] uint64_t& new_bin(int32_t number);
  void carry();
  // Carried, without bins that are 0 at either end.
  [[nodiscard]] ExactSum tidied() const;

  int32_t first_ = 0; // number of the first bin
  std::vector<uint64_t> bins_;
};

} // namespace bccsplat
