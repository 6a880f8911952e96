// SPDX-License-Identifier: Apache-2.0
// Counts samples by code or by leading bits of the float, and reads ranges and percentiles from the counts.
#include "fit/kept/histogram.h"

#include <algorithm>
#include <array>
#include <bit>

namespace bccsplat {
namespace {

constexpr uint32_t octave_bits = 11; // of the mantissa
constexpr uint32_t octave_bins = 1u << octave_bits;
constexpr uint32_t drop_bits = 23 - octave_bits;

// Rises with the value.
uint32_t ordered_key(float v) {
  const auto bits = std::bit_cast<uint32_t>(v + 0.0f); // no -0
  return bits ^ (static_cast<uint32_t>(static_cast<int32_t>(bits) >> 31) | 0x80000000u);
}

float value_of_key(uint32_t key) {
  return std::bit_cast<float>(key & 0x80000000u ? key & 0x7fffffffu : ~key);
}

} // namespace

SampleHistogram::SampleHistogram(const Quantiser& quantiser)
    : quantiser_(quantiser), code_shift_(quantiser.offset - quantiser.air),
      codes_per_unit_(1 / quantiser.scale) {
  if (largest_code(quantiser.type) > 0)
    codes_.resize(size_t{largest_code(quantiser.type)} + 1);
  else
    octaves_.resize(512);
}

inline std::vector<uint64_t>& SampleHistogram::octave(size_t o) {
  std::vector<uint64_t>& bins = octaves_[o];
  if (bins.empty()) bins.resize(octave_bins);
  return bins;
}

inline void SampleHistogram::count_values(std::span<const float> relative) {
  uint32_t keys[brick_edge], low = low_, high = high_;
  for (size_t x = 0; x < relative.size(); ++x) keys[x] = ordered_key(relative[x]);
  for (size_t x = 0; x < relative.size(); ++x) low = std::min(low, keys[x]), high = std::max(high, keys[x]);
  low_ = low, high_ = high, count_ += relative.size();
  if (codes_.empty()) {
    for (size_t x = 0; x < relative.size(); ++x)
      ++octave(keys[x] >> 23)[keys[x] >> drop_bits & (octave_bins - 1)];
    return;
  }
  const auto last = static_cast<double>(codes_.size() - 1);
  int32_t codes[brick_edge];
  for (size_t x = 0; x < relative.size(); ++x) {
    const double code = (relative[x] - code_shift_) * codes_per_unit_ + 0.5;
    codes[x] = static_cast<int32_t>(std::min(std::max(0.0, code), last)); // linear tiles go beyond; NaN: 0
  }
  for (size_t x = 0; x < relative.size(); ++x) ++codes_[codes[x]];
}

void SampleHistogram::add(const Brick& brick) {
  for (size_t r = 0; r < brick_rows; ++r) {
    const std::span<const float> row(brick.value.data() + r * brick_edge, brick_edge);
    uint32_t bits = brick.kept[r];
    if (brick.hole) bits &= ~uint32_t{(*brick.hole)[r]};
    if (bits == 0xffff) {
      count_values(row);
      continue;
    }
    for (; bits; bits &= bits - 1) count_values(row.subspan(std::countr_zero(bits), 1));
  }
}

void SampleHistogram::add_codes(std::span<const uint32_t> codes) {
  if (codes.empty()) return;
  uint32_t low = UINT32_MAX, high = 0;
  for (const uint32_t c : codes) low = std::min(low, c), high = std::max(high, c);
  if (high < 256) {
    // Several counts of each, as a count that has just been changed is slow to read.
    constexpr size_t tables = 4;
    std::array<std::array<uint32_t, 256>, tables> counts{};
    for (size_t i = 0; i < codes.size(); ++i) ++counts[i % tables][codes[i]];
    for (size_t c = low; c <= high; ++c)
      for (const auto& table : counts) codes_[c] += table[c];
  } else {
    for (const uint32_t c : codes) ++codes_[c];
  }
  count_ += codes.size();
  low_ = std::min(low_, ordered_key(relative_value(quantiser_, low)));
  high_ = std::max(high_, ordered_key(relative_value(quantiser_, high)));
}

void SampleHistogram::merge(const SampleHistogram& other) {
  if (other.count_ == 0) return;
  low_ = std::min(low_, other.low_);
  high_ = std::max(high_, other.high_);
  count_ += other.count_;
  for (size_t i = 0; i < codes_.size(); ++i) codes_[i] += other.codes_[i];
  for (size_t o = 0; o < octaves_.size(); ++o) {
    if (other.octaves_[o].empty()) continue;
    if (octaves_[o].empty()) octaves_[o].resize(octave_bins);
    for (size_t i = 0; i < octave_bins; ++i) octaves_[o][i] += other.octaves_[o][i];
  }
}

// The quantiser, the ends, and the bins that are not empty: (distance from the one before, count)
// as varints.
void SampleHistogram::write(ByteWriter& out) const {
  out.write(static_cast<uint32_t>(quantiser_.type));
  out.write(quantiser_.air), out.write(quantiser_.scale), out.write(quantiser_.offset);
  out.write(low_), out.write(high_);
  std::vector<std::pair<uint64_t, uint64_t>> bins;
  for (size_t c = 0; c < codes_.size(); ++c)
    if (codes_[c]) bins.emplace_back(c, codes_[c]);
  for (size_t o = 0; o < octaves_.size(); ++o)
    for (size_t i = 0; i < octaves_[o].size(); ++i)
      if (octaves_[o][i]) bins.emplace_back(o * octave_bins + i, octaves_[o][i]);
  out.write(static_cast<uint32_t>(bins.size()));
  uint64_t before = 0;
  for (const auto& [bin, count] : bins) {
    out.write_varint(bin - before);
    out.write_varint(count);
    before = bin;
  }
}

SampleHistogram SampleHistogram::read(ByteReader& in) {
  Quantiser quantiser;
  const auto type = in.read<uint32_t>();
  quantiser.type = static_cast<ValueType>(type);
  quantiser.air = in.read<float>(), quantiser.scale = in.read<double>(), quantiser.offset = in.read<double>();
  if (type < 1 || type > 4 || !(quantiser.scale > 0)) fail(Code::corrupt, "histogram: value type ", type);
  SampleHistogram out(quantiser);
  out.low_ = in.read<uint32_t>(), out.high_ = in.read<uint32_t>();
  const uint64_t all = out.codes_.empty() ? out.octaves_.size() * octave_bins : out.codes_.size();
  uint64_t bin = 0;
  for (auto left = in.read<uint32_t>(); left > 0; --left) {
    const uint64_t further = in.read_varint(), count = in.read_varint();
    if (further >= all || bin + further >= all)
      fail(Code::corrupt, "histogram: no bin ", bin, " + ", further);
    bin += further;
    (out.codes_.empty() ? out.octave(bin / octave_bins)[bin % octave_bins] : out.codes_[bin]) = count;
    out.count_ += count;
  }
  return out;
}

template<class Body> void SampleHistogram::for_bins(const Body& body) const {
  for (size_t c = 0; c < codes_.size(); ++c) {
    const double v = relative_value(quantiser_, static_cast<double>(c));
    if (codes_[c]) body(Bin{v, v, codes_[c]});
  }
  const double low = value_of_key(low_), high = value_of_key(high_);
  for (size_t o = 0; o < octaves_.size(); ++o)
    for (uint32_t i = 0; i < octaves_[o].size(); ++i) {
      if (octaves_[o][i] == 0) continue;
      const uint32_t key = static_cast<uint32_t>(o) << 23 | i << drop_bits;
      body(Bin{std::max(low, static_cast<double>(value_of_key(key))),
               std::min(high, static_cast<double>(value_of_key(key + (1u << drop_bits) - 1))),
               octaves_[o][i]});
    }
}

Range SampleHistogram::range() const {
  if (count_ == 0) return {};
  const double air = quantiser_.air;
  return {air + value_of_key(low_), air + value_of_key(high_)};
}

double SampleHistogram::percentile(double fraction) const {
  if (count_ == 0) return quantiser_.air;
  const double rank = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_);
  double below = 0, value = 0;
  bool found = false;
  for_bins([&](const Bin& bin) {
    if (found) return;
    const auto n = static_cast<double>(bin.count);
    value = bin.low + (bin.high - bin.low) * std::clamp((rank - below) / n, 0.0, 1.0);
    below += n;
    found = below >= rank;
  });
  return quantiser_.air + value;
}

std::vector<uint64_t> SampleHistogram::bins(int count) const {
  std::vector<uint64_t> result(count, 0);
  if (count_ == 0) return result;
  const double low = value_of_key(low_), width = (value_of_key(high_) - low) / count;
  const auto part = [&](double v) {
    return width > 0 ? std::clamp(static_cast<int64_t>((v - low) / width), int64_t{0}, int64_t{count} - 1)
                     : 0;
  };
  for_bins([&](const Bin& bin) {
    const int64_t first = part(bin.low), last = part(bin.high);
    const uint64_t parts = last - first + 1;
    for (uint64_t i = 0; i < parts; ++i) // the remainder goes to the first ones
      result[first + i] += bin.count / parts + (i < bin.count % parts ? 1 : 0);
  });
  return result;
}

} // namespace bccsplat
