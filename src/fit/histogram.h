// Counts of stored samples fine enough for percentiles, without knowing their range beforehand. Only integers
// are added, so the result depends on neither order nor threads.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "fit/quantise.h"
#include "formats/bcc4_info.h"

namespace bccsplat {

// Exact for u8 and u16: one bin per code. Floats: bins of 2^-11 of the value, 2048 per sign and power of two.
class SampleHistogram {
 public:
  SampleHistogram() = default;
  explicit SampleHistogram(const Quantiser& quantiser);

  void add(float relative); // a value relative to air, representable in the stored type
  void merge(const SampleHistogram& other);

  [[nodiscard]] uint64_t count() const { return count_; }
  // Smallest and largest sample, absolute; 0..0 when there are none.
  [[nodiscard]] Range range() const;
  // The value that `fraction` of the samples do not exceed, absolute, interpolated inside a bin.
  [[nodiscard]] double percentile(double fraction) const;
  // Counts in `bins` equal parts of range(), the last one closed.
  [[nodiscard]] std::vector<uint64_t> bins(int bins) const;

 private:
  Quantiser quantiser_;
  uint64_t count_ = 0;
  float low_ = 0, high_ = 0;
  std::vector<uint64_t> codes_;                      // integer types
  std::map<int32_t, std::vector<uint64_t>> octaves_; // floats: ordered key of sign and exponent -> bins
};

} // namespace bccsplat
