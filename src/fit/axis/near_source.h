// SPDX-License-Identifier: Apache-2.0
// Which sites of a tile have a source sample around them that is not air, found by words of bits: those of
// the samples are joined along z and along y, and looked at along x.
//
// An interpolating filter rings up to its reach beyond an edge, and the prefilter of whoever reads it rings
// on from there. The first lobe belongs to the edge: what is dropped of it is missing inside. Beyond 1.5 T it
// is not missed (tests/bench/notes/halos.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fit/axis/filter.h"

namespace bccsplat {

// How far around a site samples are looked at, along each axis, in T.
inline constexpr double near_source = 1.5;

// Samples of an axis, first and last of them, counted from the first one of the tile.
struct SampleSpan {
  size_t first = 0, last = 0;
};

// Returns the first and the last of the samples within `reach` of a site's position that the site takes, the
// nearest one among them. Along an axis that turns they are counted on beyond its ends. A span is at most 64.
[[nodiscard]] std::array<int64_t, 2> near_samples(double position, double reach, const FilterTable& table,
                                                  size_t site, int64_t nearest, bool turns, int64_t n);

// A bit for each sample of a tile.
class TileBits {
 public:
  void clear(size_t width, size_t ny, size_t nz);
  // Sets the bits of the samples along x that are not 0.
  void add_row(const float* row, size_t y, size_t z);
  // Calls take(j, k, row) for rows of sites, j along y and k along z: `row` has a bit for each sample along x
  // of which one in the spans y[j] and z[k] is set. Rows without any are left out.
  template<class Take>
  void for_rows(std::span<const SampleSpan> y, std::span<const SampleSpan> z, const Take& take) {
    for (size_t k = 0; k < z.size(); ++k) {
      join(bits_, ny_ * words_, z[k], plane_);
      for (size_t j = 0; j < y.size(); ++j)
        if (join(plane_, words_, y[j], row_)) take(j, k, row_.data());
    }
  }
  // Returns whether a bit of a row is set in a span of at most 64.
  static bool any(const uint64_t* row, const SampleSpan& x) {
    const size_t word = x.first / 64, shift = x.first % 64;
    const uint64_t low = row[word] >> shift, high = shift > 0 ? row[word + 1] << (64 - shift) : 0;
    return ((low | high) & (~uint64_t{0} >> (63 - (x.last - x.first)))) != 0;
  }

 private:
  // Joins pieces of `from` of `size` words each; one word beyond them is 0. Returns whether any bit is set.
  static bool join(const std::vector<uint64_t>& from, size_t size, const SampleSpan& span,
                   std::vector<uint64_t>& to);

  size_t width_ = 0, ny_ = 0, words_ = 0; // words of a row
  std::vector<uint64_t> bits_;            // by z, y and word
  std::vector<uint64_t> plane_, row_;     // joined along z; and along y
};

// Spans along x of the sites of a brick, at most 32 of them. Where they lie within 64 samples these are taken
// out of a row once.
class SpanGroup {
 public:
  explicit SpanGroup(std::vector<SampleSpan> spans);
  // A bit for each span: whether a bit of the row is set in it.
  [[nodiscard]] uint32_t any(const uint64_t* row) const;

 private:
  std::vector<SampleSpan> spans_;
  size_t first_ = 0;            // sample
  std::vector<uint64_t> masks_; // of the spans, counted from it; empty: they lie wider apart
};

} // namespace bccsplat
