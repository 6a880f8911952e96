// SPDX-License-Identifier: Apache-2.0
// Chosen cells are moved together as they come; products are summed in single precision where cells are
// bytes, else in double, four rows by two of them at a time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/encode/tap_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "formats/bcc4/encode/tap_rows.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Small = hn::CappedTag<float, brick_edge>;
using Wide = hn::CappedTag<double, brick_edge / 2>;

HWY_INLINE hn::Vec<Small> LoadCells(Small d, const float* cells) { return hn::LoadU(d, cells); }
HWY_INLINE hn::Vec<Wide> LoadCells(Wide d, const float* cells) {
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, Wide>(), cells));
}
// Lanes are whole, and their sum may be beyond what single precision holds.
HWY_INLINE double SumOf(Small, hn::Vec<Small> v) {
  const hn::RebindToSigned<Small> whole;
  return hn::GetLane(hn::SumOfLanes(whole, hn::ConvertTo(whole, v)));
}
HWY_INLINE double SumOf(Wide d, hn::Vec<Wide> v) { return hn::GetLane(hn::SumOfLanes(d, v)); }

template<class D>
HWY_INLINE void SumRows(D d, const float* cells, size_t stride, size_t count, size_t n,
                        NormalEquations& equations) {
  for (size_t i = 0; i <= n; i += 4)
    for (size_t j = 0; j < i + 4; j += 2) {
      const float* HWY_RESTRICT a = cells + i * stride;
      const float* HWY_RESTRICT b = cells + j * stride;
      auto s00 = hn::Zero(d), s01 = s00, s10 = s00, s11 = s00, s20 = s00, s21 = s00, s30 = s00, s31 = s00;
      for (size_t s = 0; s < count; s += hn::Lanes(d)) {
        const auto b0 = LoadCells(d, b + s), b1 = LoadCells(d, b + stride + s);
        const auto a0 = LoadCells(d, a + s), a1 = LoadCells(d, a + stride + s);
        s00 = hn::MulAdd(a0, b0, s00), s01 = hn::MulAdd(a0, b1, s01);
        s10 = hn::MulAdd(a1, b0, s10), s11 = hn::MulAdd(a1, b1, s11);
        const auto a2 = LoadCells(d, a + 2 * stride + s), a3 = LoadCells(d, a + 3 * stride + s);
        s20 = hn::MulAdd(a2, b0, s20), s21 = hn::MulAdd(a2, b1, s21);
        s30 = hn::MulAdd(a3, b0, s30), s31 = hn::MulAdd(a3, b1, s31);
      }
      auto* const sum = &equations.sum[i];
      sum[0][j] += SumOf(d, s00), sum[0][j + 1] += SumOf(d, s01);
      sum[1][j] += SumOf(d, s10), sum[1][j + 1] += SumOf(d, s11);
      sum[2][j] += SumOf(d, s20), sum[2][j + 1] += SumOf(d, s21);
      sum[3][j] += SumOf(d, s30), sum[3][j + 1] += SumOf(d, s31);
    }
}

// Writes the chosen ones of sixteen cells of each row, and up to a vector of others behind them.
void TakeCells(const float* const* rows, size_t count, unsigned chosen, size_t stride, float* to) {
  const Small d;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const unsigned bits = chosen >> x & ((1u << hn::Lanes(d)) - 1);
    if (bits == 0) continue;
    const std::array<uint8_t, 8> bytes{static_cast<uint8_t>(bits & 255), static_cast<uint8_t>(bits >> 8)};
    const auto mask = hn::LoadMaskBits(d, bytes.data());
    for (size_t i = 0; i < count; ++i) hn::CompressStore(hn::LoadU(d, rows[i] + x), mask, d, to + i * stride);
    to += std::popcount(bits);
  }
}

void SumSmallRows(const float* cells, size_t stride, size_t count, size_t n, NormalEquations& equations) {
  SumRows(Small(), cells, stride, count, n, equations);
}
void SumWideRows(const float* cells, size_t stride, size_t count, size_t n, NormalEquations& equations) {
  SumRows(Wide(), cells, stride, count, n, equations);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(TakeCells);
HWY_EXPORT(SumSmallRows);
HWY_EXPORT(SumWideRows);

TapRows::TapRows(size_t n, bool small)
    : n_(n), small_(small), cells_(std::make_unique<float[]>(NormalEquations::rows * stride)) {}

void TapRows::add(const std::array<const float*, max_taps>& taps, const float* own, unsigned chosen) {
  std::array<const float*, max_taps + 1> rows;
  std::copy_n(taps.begin(), n_, rows.begin());
  rows[n_] = own;
  HWY_DYNAMIC_DISPATCH(TakeCells)(rows.data(), n_ + 1, chosen, stride, cells_.get() + held_);
  const size_t added = std::popcount(chosen);
  held_ += added, count_ += added;
  if (held_ + brick_edge > most) sum_up();
}

const NormalEquations& TapRows::sums() {
  sum_up();
  return equations_;
}

void TapRows::sum_up() {
  const size_t end = (held_ + brick_edge - 1) / brick_edge * brick_edge;
  for (size_t i = 0; i <= n_; ++i) std::fill(&cells_[i * stride + held_], &cells_[i * stride + end], 0.0f);
  if (small_)
    HWY_DYNAMIC_DISPATCH(SumSmallRows)(cells_.get(), stride, end, n_, equations_);
  else
    HWY_DYNAMIC_DISPATCH(SumWideRows)(cells_.get(), stride, end, n_, equations_);
  held_ = 0;
}

} // namespace bccsplat
#endif
