// SPDX-License-Identifier: Apache-2.0
#include "fit/axis/near_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/axis/nonzero_bits.h"

namespace bccsplat {

std::array<int64_t, 2> near_samples(double position, double reach, const FilterTable& table, size_t site,
                                    int64_t nearest, bool turns, int64_t n) {
  reach = std::min(reach, 31.0);
  std::array<int64_t, 2> near{
      std::max(table.first[site], static_cast<int64_t>(std::ceil(position - reach))),
      std::min(table.first[site] + table.taps - 1, static_cast<int64_t>(std::floor(position + reach)))};
  for (int64_t& sample : near)
    if (!turns) sample = std::clamp<int64_t>(sample, 0, n - 1);
  return {std::min(near[0], nearest), std::max(near[1], nearest)};
}

void TileBits::clear(size_t width, size_t ny, size_t nz) {
  width_ = width, ny_ = ny, words_ = (width + 63) / 64;
  bits_.assign(nz * ny * words_, 0);
}

void TileBits::add_row(const float* row, size_t y, size_t z) {
  nonzero_bits(row, width_, bits_.data() + (z * ny_ + y) * words_);
}

bool TileBits::join(const std::vector<uint64_t>& from, size_t size, const SampleSpan& span,
                    std::vector<uint64_t>& to) {
  to.assign(size + 1, 0);
  uint64_t all = 0;
  for (size_t s = span.first; s <= span.last; ++s)
    for (size_t i = 0; i < size; ++i) {
      to[i] |= from[s * size + i];
      all |= from[s * size + i];
    }
  return all != 0;
}

SpanGroup::SpanGroup(std::vector<SampleSpan> spans) : spans_(std::move(spans)) {
  size_t end = 0;
  first_ = SIZE_MAX;
  for (const SampleSpan& s : spans_) first_ = std::min(first_, s.first), end = std::max(end, s.last + 1);
  if (spans_.empty() || end - first_ > 64) return;
  for (const SampleSpan& s : spans_)
    masks_.push_back(~uint64_t{0} >> (63 - (s.last - s.first)) << (s.first - first_));
}

uint32_t SpanGroup::any(const uint64_t* row) const {
  uint32_t found = 0;
  if (masks_.empty()) {
    for (size_t i = 0; i < spans_.size(); ++i)
      found |= static_cast<uint32_t>(TileBits::any(row, spans_[i])) << i;
    return found;
  }
  const size_t word = first_ / 64, shift = first_ % 64;
  const uint64_t bits = row[word] >> shift | (shift > 0 ? row[word + 1] << (64 - shift) : 0);
  if (bits == 0) return 0;
  for (size_t i = 0; i < masks_.size(); ++i) found |= static_cast<uint32_t>((bits & masks_[i]) != 0) << i;
  return found;
}

} // namespace bccsplat
