// SPDX-License-Identifier: Apache-2.0
// Counts of stored samples fine enough for percentiles, without knowing their range beforehand. Only integers
// are added, so the result depends on neither order nor threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "fit/kept/quantise.h"
#include "points/brick.h"
#include "points/values.h"

namespace bccsplat {

// Exact for u8 and u16: one bin per code. Floats: 2048 bins for each sign and power of two of the value
// relative to air, so a bin is at most 2^-11 of its values wide.
class SampleHistogram {
 public:
  SampleHistogram() = default;
  explicit SampleHistogram(const Quantiser& quantiser);

  // The sites of a brick that are kept and no holes; their values are representable in the stored type.
  void add(const Brick& brick);
  // The same of all sites of a brick by their codes, which have one or two bytes.
  void add_codes(std::span<const uint32_t> codes);
  void merge(const SampleHistogram& other); // of an equal quantiser

  void write(ByteWriter& out) const;
  [[nodiscard]] static SampleHistogram read(ByteReader& in); // throws corrupt, truncated

  [[nodiscard]] uint64_t count() const { return count_; }
  // Smallest and largest sample, absolute; 0..0 when there are none.
  [[nodiscard]] Range range() const;
  // The smallest value, absolute, that at least `fraction` of the samples do not exceed; interpolated inside
  // a bin.
  [[nodiscard]] double percentile(double fraction) const;
  // Counts in `count` equal parts of range(), the last one closed; a bin that straddles two parts is divided
  // evenly.
  [[nodiscard]] std::vector<uint64_t> bins(int count) const;

 private:
  // Samples of equal or nearly equal value, relative to air.
  struct Bin {
    double low, high;
    uint64_t count;
  };
  template<class Body> void for_bins(const Body& body) const; // rising
  [[nodiscard]] std::vector<uint64_t>& octave(size_t o);
  void count_values(std::span<const float> relative); // at most a row

  Quantiser quantiser_;
  double code_shift_ = 0, codes_per_unit_ = 1;
  uint64_t count_ = 0;
  // Keys, which rise with the value, of the smallest and the largest sample.
  uint32_t low_ = UINT32_MAX, high_ = 0;
  std::vector<uint64_t> codes_; // integers
  std::vector<std::vector<uint64_t>>
      octaves_; // floats, by sign and exponent in rising order; empty or 2048 bins
};

} // namespace bccsplat
