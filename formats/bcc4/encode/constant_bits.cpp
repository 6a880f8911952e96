// SPDX-License-Identifier: Apache-2.0
// Counts how often each residual occurs, row by row, and goes on without predictors that have cost too much.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/encode/constant_bits.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>
#include <memory>

#include "formats/bcc4/coding/entropy.h"
#include "formats/bcc4/coding/predict_taps-inl.h"
#include "formats/bcc4/encode/constant_bits.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

// One for each predictor and site of a row.
using RowResiduals = std::array<std::array<uint32_t, brick_edge>, constant_predictors>;

// The differences of the sixteen sites of a row to each prediction, folded.
HWY_INLINE void PredictRow(const Row<int32_t>& row, int32_t air, uint32_t mask, RowResiduals& out) {
  const hn::CappedTag<int32_t, brick_edge> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto low = hn::Set(d, -air), high = hn::Set(d, static_cast<int32_t>(mask) - air);
  const auto all = hn::Set(d, static_cast<int32_t>(mask)), half = hn::Set(d, static_cast<int32_t>(mask / 2));
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const int32_t* own = row.own + x;
    const auto at = [&](std::ptrdiff_t offset) HWY_ATTR { return hn::LoadU(d, own + offset); };
    const auto put = [&](Predictor p, auto residuals) HWY_ATTR {
      hn::StoreU(hn::BitCast(du, residuals), du, out[static_cast<size_t>(p)].data() + x);
    };
    const auto site = at(0), west = at(-1);
    const auto put_difference = [&](Predictor p, auto prediction) HWY_ATTR {
      const auto limited = hn::Min(hn::Max(prediction, low), high);
      const auto above = hn::And(hn::Sub(site, limited), all);
      const auto twice = hn::Add(above, above);
      const auto below = hn::Sub(hn::Set(d, static_cast<int32_t>(2 * mask + 1)), twice);
      put(p, hn::And(hn::IfThenElse(hn::Gt(above, half), below, twice), all));
    };
    put(Predictor::none, hn::Add(site, hn::Set(d, air)));
    put_difference(Predictor::west, west);
    const auto added =
        hn::Add(hn::Add(west, at(-stride_y)), hn::Add(at(-stride_z), at(-1 - stride_y - stride_z)));
    const auto taken = hn::Add(hn::Add(at(-1 - stride_y), at(-1 - stride_z)), at(-stride_y - stride_z));
    put_difference(Predictor::lorenzo, hn::Sub(added, taken));
    auto previous = west, corners = west;
    if (row.previous) previous = corners = hn::LoadU(d, row.previous + x);
    if (row.cross) {
      corners = hn::Set(d, cross_taps / 2);
      for (int i = 0; i < cross_taps; ++i)
        corners = hn::Add(corners, hn::LoadU(d, row.cross + cross_offset(i) + x));
      corners = hn::ShiftRight<3>(corners);
      if (!row.previous) previous = corners;
    }
    put_difference(Predictor::previous, previous);
    put_difference(Predictor::cross, corners);
  }
}

// How often each byte of the residuals of one predictor occurs; two counts of each, as a count that has just
// been changed is slow to read.
class ByteCounts {
 public:
  HWY_INLINE void add(const std::array<uint32_t, brick_edge>& residuals, unsigned kept, uint32_t bytes) {
    for (uint32_t b = 0; b < bytes; ++b) {
      auto& counts = counts_[b];
      if (kept == full_row)
        for (size_t x = 0; x < brick_edge; x += 2)
          ++counts[0][residuals[x] >> (8 * b) & 255], ++counts[1][residuals[x + 1] >> (8 * b) & 255];
      else
        for (unsigned bits = kept; bits; bits &= bits - 1)
          ++counts[0][residuals[std::countr_zero(bits)] >> (8 * b) & 255];
    }
  }
  [[nodiscard]] uint64_t bits_256(uint32_t bytes) const {
    uint64_t sum = 0;
    for (uint32_t b = 0; b < bytes; ++b) {
      std::array<uint32_t, 256> both;
      for (size_t i = 0; i < both.size(); ++i) both[i] = counts_[b][0][i] + counts_[b][1][i];
      sum += entropy_bits_256(both);
    }
    return sum;
  }

 private:
  std::array<std::array<std::array<uint32_t, 256>, 2>, 2> counts_{};
};

// Bits of some of the sites are no more than those of all. Logarithms are too low by up to 0.09, with either.
constexpr uint64_t slack_256 = 24;

std::array<uint64_t, constant_predictors> ConstantBits(const ChunkSites& sites, const ChunkCodes& codes,
                                                       uint64_t limit) {
  const uint32_t mask = codes.mask(), bytes = codes.bytes();
  const int32_t air = codes.air;
  const auto counts = std::make_unique<std::array<ByteCounts, constant_predictors>>();
  std::array<uint64_t, constant_predictors> result{};
  unsigned left = (1u << constant_predictors) - 1; // predictors
  const uint32_t* code = sites.codes.data();
  int layer = 0;
  const auto leave_out = [&] {
    const uint64_t seen = code - sites.codes.data();
    const uint64_t too_many = limit + slack_256 * bytes * (seen + sites.codes.size());
    for (size_t p = 0; p < constant_predictors; ++p)
      if (left >> p & 1 && (*counts)[p].bits_256(bytes) > too_many)
        result[p] = UINT64_MAX, left &= ~(1u << p);
  };
  CellRing<int32_t> ring;
  walk_rows<int32_t>(sites.shape, sites.kept, ring, [&](const Row<int32_t>& row) HWY_ATTR {
    if (row.layer != layer) leave_out(), layer = row.layer;
    if (left == 0) return;
    const unsigned kept = sites.kept[row.layer][row.index];
    code = FillRow(row.own, code, kept, air);
    RowResiduals residuals;
    PredictRow(row, air, mask, residuals);
    for (unsigned p = left; p; p &= p - 1) {
      const size_t i = std::countr_zero(p);
      (*counts)[i].add(residuals[i], kept, bytes);
    }
  });
  for (size_t p = 0; p < constant_predictors; ++p)
    if (left >> p & 1) result[p] = (*counts)[p].bits_256(bytes);
  return result;
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(ConstantBits);

std::array<uint64_t, constant_predictors> constant_bits(const ChunkSites& sites, const ChunkCodes& codes,
                                                        uint64_t limit) {
  return HWY_DYNAMIC_DISPATCH(ConstantBits)(sites, codes, limit);
}

} // namespace bccsplat
#endif
