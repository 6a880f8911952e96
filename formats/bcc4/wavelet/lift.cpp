// SPDX-License-Identifier: Apache-2.0
// Lines that lie side by side are lifted row by row, with even and odd rows in turn. A line along x is taken
// apart into its even and its odd samples, which are lifted as two rows shifted against each other.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/wavelet/lift.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "formats/bcc4/wavelet/lift.h"

#ifndef BCCSPLAT_LIFT_STEPS
#define BCCSPLAT_LIFT_STEPS
namespace bccsplat {
namespace {

// Predict, update, predict, update (Daubechies and Sweldens 1998), and the scale of the coarse half.
alignas(64) constexpr float lifting[4] = {-1.586134342F, -0.05298011854F, 0.8829110762F, 0.4435068522F};
constexpr double exact_scale = 1.149604398;
constexpr auto coarse_scale = static_cast<float>(exact_scale),
               fine_scale = static_cast<float>(1 / exact_scale);

// Rows in the scratch begin so many floats apart, so that whole vectors of any target stay inside.
constexpr size_t whole_vectors = 16;
constexpr size_t padded(size_t width) { return (width + whole_vectors - 1) / whole_vectors * whole_vectors; }
constexpr int most_across = 64; // lines that are lifted at once: their samples stay in the cache

// Where sample i of a line is, whose coarse half comes first.
size_t split_place(int i, int count) { return i % 2 == 0 ? i / 2 : (count + 1) / 2 + i / 2; }

} // namespace
} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

void CopyScaled(const float* from, float factor, size_t n, float* to) {
  const hn::ScalableTag<float> d;
  const auto by = hn::Set(d, factor);
  size_t i = 0;
  for (; i + hn::Lanes(d) <= n; i += hn::Lanes(d)) hn::StoreU(hn::Mul(hn::LoadU(d, from + i), by), d, to + i);
  for (; i < n; ++i) to[i] = from[i] * factor;
}

// Adds weight * (a + b) to whole vectors, as many as hold `width` values.
void AddNeighbours(float* to, const float* a, const float* b, float weight, size_t width) {
  const hn::ScalableTag<float> d;
  const auto w = hn::Set(d, weight);
  for (size_t i = 0; i < width; i += hn::Lanes(d)) {
    const auto both = hn::Add(hn::LoadU(d, a + i), hn::LoadU(d, b + i));
    hn::StoreU(hn::Add(hn::LoadU(d, to + i), hn::Mul(w, both)), d, to + i);
  }
}

// Adds to each row of one parity its two neighbours, mirrored at the ends.
void LiftRows(float* rows, size_t pitch, int count, size_t width, int parity, float weight) {
  for (int i = parity; i < count; i += 2) {
    const size_t before = i > 0 ? i - 1 : 1, after = i + 1 < count ? i + 1 : count - 2;
    AddNeighbours(rows + i * pitch, rows + before * pitch, rows + after * pitch, weight, width);
  }
}

void LiftAcross(const LineBlock& b, bool inverse, float* rows) {
  const size_t width = b.lines, pitch = padded(width);
  for (int i = 0; i < b.count; ++i) {
    const float factor = i % 2 == 0 ? fine_scale : coarse_scale;
    if (inverse)
      CopyScaled(b.first + split_place(i, b.count) * b.stride, factor, width, rows + i * pitch);
    else
      std::copy_n(b.first + i * b.stride, width, rows + i * pitch);
  }
  for (int step = 0; step < 4; ++step) {
    const int s = inverse ? 3 - step : step;
    LiftRows(rows, pitch, b.count, width, 1 - s % 2, inverse ? -lifting[s] : lifting[s]);
  }
  for (int i = 0; i < b.count; ++i) {
    const float factor = i % 2 == 0 ? coarse_scale : fine_scale;
    if (inverse)
      std::copy_n(rows + i * pitch, width, b.first + i * b.stride);
    else
      CopyScaled(rows + i * pitch, factor, width, b.first + split_place(i, b.count) * b.stride);
  }
}

void TakeApart(const float* line, int count, float* even, float* odd) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    hn::Vec<decltype(d)> a, b;
    hn::LoadInterleaved2(d, line + i, a, b);
    hn::StoreU(a, d, even + i / 2);
    hn::StoreU(b, d, odd + i / 2);
  }
  for (; i < count; ++i) (i % 2 == 0 ? even : odd)[i / 2] = line[i];
}

void PutTogether(const float* even, const float* odd, int count, float* line) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes)
    hn::StoreInterleaved2(hn::LoadU(d, even + i / 2), hn::LoadU(d, odd + i / 2), d, line + i);
  for (; i < count; ++i) line[i] = (i % 2 == 0 ? even : odd)[i / 2];
}

// One step on the samples of one parity. Beyond its ends the other row has the mirror image; what whole
// vectors add behind a row is written anew before it is used.
void LiftSplit(float* even, float* odd, int count, int parity, float weight) {
  const int coarse = (count + 1) / 2, fine = count / 2;
  if (parity == 1) {
    if (coarse == fine) even[coarse] = even[coarse - 1];
    AddNeighbours(odd, even, even + 1, weight, fine);
  } else {
    odd[-1] = odd[0];
    if (coarse > fine) odd[fine] = odd[fine - 1];
    AddNeighbours(even, odd - 1, odd, weight, coarse);
  }
}

void LiftAlong(const LineBlock& b, bool inverse, float* rows) {
  const int coarse = (b.count + 1) / 2, fine = b.count / 2;
  const size_t half = padded(coarse + 1);
  float *const even = rows, *const odd = rows + half + whole_vectors;
  for (int l = 0; l < b.lines; ++l) {
    float* const line = b.first + l * b.stride;
    if (inverse) {
      CopyScaled(line, fine_scale, coarse, even);
      CopyScaled(line + coarse, coarse_scale, fine, odd);
    } else {
      TakeApart(line, b.count, even, odd);
    }
    for (int step = 0; step < 4; ++step) {
      const int s = inverse ? 3 - step : step;
      LiftSplit(even, odd, b.count, 1 - s % 2, inverse ? -lifting[s] : lifting[s]);
    }
    if (inverse) {
      PutTogether(even, odd, b.count, line);
    } else {
      CopyScaled(even, coarse_scale, coarse, line);
      CopyScaled(odd, fine_scale, fine, line + coarse);
    }
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(LiftAcross);
HWY_EXPORT(LiftAlong);

void lift_across(const LineBlock& block, bool inverse, std::vector<float>& scratch) {
  scratch.resize(std::max(scratch.size(), block.count * padded(most_across)));
  LineBlock part = block;
  for (int x = 0; x < block.lines; x += most_across) {
    part.first = block.first + x;
    part.lines = std::min(most_across, block.lines - x);
    HWY_DYNAMIC_DISPATCH(LiftAcross)(part, inverse, scratch.data());
  }
}

void lift_along(const LineBlock& block, bool inverse, std::vector<float>& scratch) {
  // Two rows, the mirror images beyond their ends, and a vector behind each.
  const size_t half = padded((block.count + 1) / 2 + 1);
  scratch.resize(std::max(scratch.size(), 2 * half + 3 * whole_vectors));
  HWY_DYNAMIC_DISPATCH(LiftAlong)(block, inverse, scratch.data());
}

} // namespace bccsplat
#endif
