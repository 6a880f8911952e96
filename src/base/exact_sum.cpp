// SPDX-License-Identifier: Apache-2.0
#include "base/exact_sum.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

constexpr uint64_t bin_size = 256;  // what a bin holds when it is carried
constexpr int exponent_bias = 1062; // a whole number of 40 bits times 2^(exponent - bias) is the double

} // namespace

uint64_t& ExactSum::new_bin(int32_t number) {
  if (bins_.empty()) first_ = number;
  if (number < first_) {
    bins_.insert(bins_.begin(), static_cast<size_t>(first_ - number), 0);
    first_ = number;
  }
  const auto at = static_cast<size_t>(number - first_);
  bins_.resize(std::max(bins_.size(), at + 1));
  return bins_[at];
}

// A bin has room for 2^15 numbers.
void ExactSum::add(std::span<const double> values) {
  std::array<uint64_t, all_bins> bins{};
  for (const double v : values) {
    const uint64_t bits = std::bit_cast<uint64_t>(v) + (uint64_t{1} << (dropped_bits - 1));
    const uint64_t exponent = bits >> fraction_bits, unit = exponent == 0 ? 0 : fraction_mask + 1,
                   whole = exponent == 0 ? 0 : ((bits & fraction_mask) | unit) >> dropped_bits;
    bins[exponent / bin_exponents % all_bins] += whole << (exponent % bin_exponents);
  }
  for (size_t i = 0; i < bins.size(); ++i) {
    if (bins[i] == 0) continue;
    uint64_t& bin = bin_at(static_cast<int32_t>(i));
    bin += bins[i];
    if (bin >> full_bits != 0) carry();
  }
}

void ExactSum::carry() {
  uint64_t over = 0;
  for (uint64_t& bin : bins_) {
    bin += over;
    over = bin / bin_size, bin %= bin_size;
  }
  for (; over > 0; over /= bin_size) bins_.push_back(over % bin_size);
}

void ExactSum::add(const ExactSum& other) {
  for (size_t i = 0; i < other.bins_.size(); ++i)
    bin_at(other.first_ + static_cast<int32_t>(i)) += other.bins_[i];
  carry();
}

ExactSum ExactSum::tidied() const {
  ExactSum tidy = *this;
  tidy.carry();
  const auto is_used = [](uint64_t bin) { return bin != 0; };
  const auto begin = std::find_if(tidy.bins_.begin(), tidy.bins_.end(), is_used);
  tidy.first_ += static_cast<int32_t>(begin - tidy.bins_.begin());
  tidy.bins_.erase(tidy.bins_.begin(), begin);
  while (!tidy.bins_.empty() && !is_used(tidy.bins_.back())) tidy.bins_.pop_back();
  return tidy;
}

double ExactSum::value() const {
  const ExactSum tidy = tidied();
  double sum = 0; // from the smallest bin on
  for (size_t i = 0; i < tidy.bins_.size(); ++i)
    sum += std::ldexp(static_cast<double>(tidy.bins_[i]),
                      (tidy.first_ + static_cast<int>(i)) * bin_exponents - exponent_bias);
  return sum;
}

void ExactSum::write(ByteWriter& out) const {
  const ExactSum tidy = tidied();
  out.write(static_cast<uint16_t>(tidy.first_)), out.write(static_cast<uint16_t>(tidy.bins_.size()));
  for (const uint64_t bin : tidy.bins_) out.write(static_cast<uint8_t>(bin));
}

ExactSum ExactSum::read(ByteReader& in) {
  ExactSum sum;
  sum.first_ = in.read<uint16_t>();
  sum.bins_.resize(in.read<uint16_t>());
  if (sum.first_ > all_bins || sum.bins_.size() > all_bins)
    fail(Code::corrupt, "a sum of ", sum.bins_.size(), " bins from ", sum.first_, " on");
  for (uint64_t& bin : sum.bins_) bin = in.read<uint8_t>();
  return sum;
}

} // namespace bccsplat
