// SPDX-License-Identifier: Apache-2.0
// Decodes planes all of whose sites are kept, of codes of one byte. What a site takes from other
// planes and layers is summed for four rows at a time. Where each site also waits for the one before it, the
// rows stand in the lanes of vectors, each two sites behind the row before it, of which it needs the next
// site: x + 2 y is the step at which site (x, y) is decoded. This file is included once per target.
#if defined(BCCSPLAT_UNPREDICT_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_UNPREDICT_PLANES_INL_H
#undef BCCSPLAT_UNPREDICT_PLANES_INL_H
#else
#define BCCSPLAT_UNPREDICT_PLANES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "formats/bcc4/coding/unpredict_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

#if HWY_TARGET != HWY_SCALAR
// Four lanes of four vectors from where `at` points change places.
HWY_INLINE void Transpose4(const int32_t* HWY_RESTRICT from, std::ptrdiff_t from_pitch,
                           int32_t* HWY_RESTRICT to, std::ptrdiff_t to_pitch) {
  const hn::FixedTag<int32_t, 4> d;
  const hn::FixedTag<int64_t, 2> pairs;
  const auto a = hn::LoadU(d, from), b = hn::LoadU(d, from + from_pitch),
             c = hn::LoadU(d, from + 2 * from_pitch), e = hn::LoadU(d, from + 3 * from_pitch);
  const auto ab = hn::BitCast(pairs, hn::InterleaveLower(d, a, b)),
             ce = hn::BitCast(pairs, hn::InterleaveLower(d, c, e)),
             ab_up = hn::BitCast(pairs, hn::InterleaveUpper(d, a, b)),
             ce_up = hn::BitCast(pairs, hn::InterleaveUpper(d, c, e));
  hn::StoreU(hn::BitCast(d, hn::InterleaveLower(pairs, ab, ce)), d, to);
  hn::StoreU(hn::BitCast(d, hn::InterleaveUpper(pairs, ab, ce)), d, to + to_pitch);
  hn::StoreU(hn::BitCast(d, hn::InterleaveLower(pairs, ab_up, ce_up)), d, to + 2 * to_pitch);
  hn::StoreU(hn::BitCast(d, hn::InterleaveUpper(pairs, ab_up, ce_up)), d, to + 3 * to_pitch);
}

class FullPlanes {
 public:
  FullPlanes(const CodeLimits& limits, const LayerTaps& layer_taps) : limits_(limits), taps_(layer_taps) {}

  // Decodes the plane whose first row is `row` and which has `height` of them; `repeats`: the cell before a
  // row repeats the first one of the row before it, else it is in place. The cells behind rows repeat the
  // last ones.
  void Decode(const Row<int32_t>& row, int height, const Taps& taps, bool repeats,
              PackedRows<uint8_t>& rows) {
    width_ = row.width, height_ = height;
    Sum(row.own, taps, reinterpret_cast<const uint8_t*>(rows.planes) + rows.at);
    // Row j of four goes to its steps, and back to its cells, 2 j before those of the first.
    const int block_steps = (width_ + 6 + 3) / 4 * 4;
    const auto for_blocks = [&](const auto& body) {
      for (int y = 0; y < height_; y += 4)
        for (int x = 0; x < block_steps; x += 4) body(Step(2 * y + x) + y, Cell(x, y));
    };
    for_blocks([](int32_t* in_steps, int32_t* cells)
                   HWY_ATTR { Transpose4(cells, pitch - 2, in_steps, brick_edge); });
    for (int y = 0; y < height_; y += static_cast<int>(hn::Lanes(D()))) DecodeRows(row.own, taps, repeats, y);
    for_blocks([](int32_t* in_steps, int32_t* cells)
                   HWY_ATTR { Transpose4(in_steps, brick_edge, cells, pitch - 2); });
    Write(row.own, repeats, reinterpret_cast<uint8_t*>(rows.packed) + rows.at);
    rows.at += static_cast<std::ptrdiff_t>(width_) * height_;
  }

 private:
  // Rows stand apart, for what is moved beside them: the steps of four rows begin 6 sites before the last
  // one.
  static constexpr int pitch = brick_edge + 16, beside = 8, steps = 3 * brick_edge;
  using D = hn::CappedTag<int32_t, brick_edge>;

  int32_t* Cell(int x, int y) { return cells_ + y * pitch + beside + x; }
  int32_t* Step(int s) { return by_step_ + s * brick_edge; }

  // Puts, for each site, what is known of its prediction, in 24 bits by the rule for weights, over its
  // residual. Codes instead of cells will be added to it.
  void Sum(const int32_t* own, const Taps& taps, const uint8_t* HWY_RESTRICT residuals) {
    const D d;
    const hn::Rebind<uint8_t, D> d8;
    const size_t count = taps_.count - taps.near.count;
    const int32_t air =
        static_cast<int32_t>(limits_.air) * (taps.west + taps.north + taps.northwest + taps.northeast);
    for (int y = 0; y < height_; y += 4)
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
        const auto start = hn::Set(d, (1 << (fraction_bits - 1)) - air);
        auto a = start, b = start, c = start, e = start;
        for (size_t t = 0; t < count; ++t) {
          const int32_t* cells = own + taps_.offset[t] + y * stride_y + x;
          const int32_t weight = taps_.weight[t];
          a = AddWeighted<1>(d, a, hn::LoadU(d, cells), weight);
          b = AddWeighted<1>(d, b, hn::LoadU(d, cells + stride_y), weight);
          c = AddWeighted<1>(d, c, hn::LoadU(d, cells + 2 * stride_y), weight);
          e = AddWeighted<1>(d, e, hn::LoadU(d, cells + 3 * stride_y), weight);
        }
        const auto put = [&](int j, auto sum) HWY_ATTR {
          const auto* from = residuals + (y + j) * width_ + x;
          const auto residual = hn::PromoteTo(d, hn::LoadU(d8, from));
          hn::StoreU(hn::Or(hn::ShiftLeft<8>(sum), residual), d, Cell(static_cast<int>(x), y + j));
        };
        put(0, a), put(1, b), put(2, c), put(3, e);
      }
  }

  // Decodes as many rows as a vector has lanes, from row `first` on. Lanes hold the cell before a row until
  // it begins, and its last one when it has ended.
  void DecodeRows(const int32_t* own, const Taps& taps, bool repeats, int first) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const int32_t air = limits_.air;
    int32_t north[2 * brick_edge + 2 * brick_edge]{}; // codes of the row before, from x = -1 on
    for (int x = -1; x <= width_; ++x)
      north[x + 1] =
          first == 0 ? own[x - stride_y] + air : Step(2 * (first - 1) + std::min(x, width_ - 1))[first - 1];
    int32_t border[brick_edge], before[brick_edge];
    for (int y = 0; y < lanes; ++y) {
      border[y] = repeats ? north[1] : own[(first + y) * stride_y - 1] + air;
      before[y] = std::max(y - 1, 0);
    }
    const auto up = hn::SetTableIndices(d, before);
    const auto lowest = hn::FirstN(d, 1);
    const auto above = [&](auto v, int x) HWY_ATTR { // of the row before, x in the first lane
      return hn::IfThenElse(lowest, hn::Set(d, north[x + 1]), hn::TableLookupLanes(v, up));
    };
    const auto low = hn::Set(d, limits_.low), high = hn::Set(d, limits_.high), mask = hn::Set(d, 255);
    const auto zero = hn::Zero(d), one = hn::Set(d, 1), width = hn::Set(d, width_);
    auto west = hn::LoadU(d, border), middle = above(west, 0), left = above(west, -1);
    auto x = hn::Mul(hn::Iota(d, 0), hn::Set(d, -2));
    const int32_t to_west = taps.west, to_north = taps.north, to_left = taps.northwest,
                  to_right = taps.northeast;
    const int end = width_ + 2 * (std::min(lanes, height_ - first) - 1);
    for (int s = 0; s < end; ++s, x = hn::Add(x, one)) {
      int32_t* const at = Step(2 * first + s) + first;
      const auto given = hn::LoadU(d, at);
      const auto residual = hn::And(given, mask);
      const auto step = hn::Add(hn::Xor(hn::ShiftRight<1>(residual), hn::Sub(zero, hn::And(residual, one))),
                                hn::Set(d, air));
      const auto right = above(west, s + 1);
      auto sum = AddWeighted<1>(d, hn::ShiftRight<8>(given), left, to_left);
      sum = AddWeighted<1>(d, sum, middle, to_north);
      sum = AddWeighted<1>(d, sum, west, to_west);
      sum = AddWeighted<1>(d, sum, right, to_right);
      const auto p = hn::Min(hn::Max(hn::ShiftRight<fraction_bits>(sum), low), high);
      const auto inside = hn::And(hn::Gt(x, hn::Set(d, -1)), hn::Lt(x, width));
      auto code = hn::IfThenElse(inside, hn::And(hn::Add(p, step), mask), west);
      if (repeats) code = hn::IfThenElse(hn::Eq(x, hn::Set(d, -1)), right, code);
      hn::StoreU(code, d, at);
      west = code, left = middle, middle = right;
    }
  }

  void Write(int32_t* own, bool repeats, uint8_t* HWY_RESTRICT packed) {
    const D d;
    const hn::Rebind<uint8_t, D> d8;
    const int32_t air = limits_.air;
    const int width = width_;
    for (int y = 0; y < height_; ++y, own += stride_y, packed += width) {
      const int32_t* const codes = Cell(0, y);
      for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(d))) {
        const auto code = hn::LoadU(d, codes + x);
        const auto inside = hn::FirstN(d, width - x);
        hn::StoreU(hn::DemoteTo(d8, code), d8, packed + x);
        hn::StoreU(hn::IfThenElseZero(inside, hn::Sub(code, hn::Set(d, air))), d, own + x);
      }
      // The cells have just been written, so that this comes from the codes.
      if (repeats) own[-1] = y == 0 ? own[-stride_y] : codes[-pitch] - air;
      own[width] = codes[width - 1] - air;
    }
  }

  const CodeLimits& limits_;
  const LayerTaps& taps_;
  int width_ = 0, height_ = 0;
  alignas(64) int32_t by_step_[steps * brick_edge]{};
  alignas(64) int32_t cells_[pitch * brick_edge]{};
};
#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif
