// SPDX-License-Identifier: Apache-2.0
// The loops of point_sizes.h through Highway: one body is compiled for every target, and the best is chosen
// at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/points/point_sizes_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "splat/points/point_sizes.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
void Within(const FineCube& cube, const FineBall& ball, FineCells& out) {
  out = cells_within_reference(cube, ball);
}
uint32_t Take(const SplatPoints& points, const SplatBrick& brick, const FineCells& cells, uint16_t* position,
              float* coefficient) {
  return take_points_reference(points, brick, cells, position, coefficient);
}
#else

namespace hn = hwy::HWY_NAMESPACE;

void Within(const FineCube& cube, const FineBall& ball, FineCells& out) {
  constexpr size_t side = FineCube::side, count = side * side, margin = FineCube::margin;
  const hn::CappedTag<uint16_t, 32> dw;
  // wide[r] holds the rows widened by r cells along x, and a few rows more, because whole vectors are read.
  constexpr size_t pitch = (count + 16 + 31) / 32 * 32;
  alignas(64) uint16_t wide[margin + 1][pitch];
  for (size_t n = 0; n < count; n += hn::Lanes(dw)) {
    const auto row = hn::LoadU(dw, cube.row.data() + n);
    auto sum = row;
    hn::Store(sum, dw, wide[0] + n);
    for (size_t r = 1; r <= margin; ++r) {
      const int bits = static_cast<int>(r);
      sum = hn::Or(sum, hn::Or(hn::ShiftLeftSame(row, bits), hn::ShiftRightSame(row, bits)));
      hn::Store(sum, dw, wide[r] + n);
    }
  }
  // Each sum is one of eight planes z and holds eight rows y.
  const hn::FixedTag<uint16_t, 8> d;
  auto s0 = hn::Zero(d), s1 = s0, s2 = s0, s3 = s0, s4 = s0, s5 = s0, s6 = s0, s7 = s0;
  for (size_t n = 0; n < ball.reach.size(); ++n) {
    if (ball.reach[n] < 0) continue;
    const uint16_t* const from = wide[ball.reach[n]] + n / FineBall::side * side + n % FineBall::side;
    s0 = hn::Or(s0, hn::LoadU(d, from)), s1 = hn::Or(s1, hn::LoadU(d, from + side));
    s2 = hn::Or(s2, hn::LoadU(d, from + 2 * side)), s3 = hn::Or(s3, hn::LoadU(d, from + 3 * side));
    s4 = hn::Or(s4, hn::LoadU(d, from + 4 * side)), s5 = hn::Or(s5, hn::LoadU(d, from + 5 * side));
    s6 = hn::Or(s6, hn::LoadU(d, from + 6 * side)), s7 = hn::Or(s7, hn::LoadU(d, from + 7 * side));
  }
  alignas(16) uint16_t rows[64];
  hn::Store(s0, d, rows), hn::Store(s1, d, rows + 8), hn::Store(s2, d, rows + 16);
  hn::Store(s3, d, rows + 24), hn::Store(s4, d, rows + 32), hn::Store(s5, d, rows + 40);
  hn::Store(s6, d, rows + 48), hn::Store(s7, d, rows + 56);
  out = {};
  for (size_t n = 0; n < 64; ++n)
    out[n / 8] |= static_cast<uint64_t>(rows[n] >> margin & 255) << (8 * (n % 8));
}

uint32_t Take(const SplatPoints& points, const SplatBrick& brick, const FineCells& cells, uint16_t* position,
              float* coefficient) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint16_t, decltype(d)> d16;
  alignas(64) int32_t word[16];
  for (size_t n = 0; n < 8; ++n) {
    word[2 * n] = static_cast<uint32_t>(cells[n]);
    word[2 * n + 1] = static_cast<uint32_t>(cells[n] >> 32);
  }
  const uint16_t* const from = points.position.data() + brick.first;
  const float* const c = points.coefficient.data() + brick.first;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(d));
  uint32_t count = 0, n = 0;
  // What is written never passes what is read: whole vectors stay among the brick's points.
  for (; n + lanes <= brick.count; n += lanes) {
    const auto packed = hn::PromoteTo(di, hn::LoadU(d16, from + n));
    const auto cell = hn::Or(hn::Or(hn::And(hn::ShiftRight<1>(packed), hn::Set(di, 7)),
                                    hn::And(hn::ShiftRight<2>(packed), hn::Set(di, 56))),
                             hn::And(hn::ShiftRight<3>(packed), hn::Set(di, 448)));
    const auto bits =
        hn::Shr(hn::GatherIndex(di, word, hn::ShiftRight<5>(cell)), hn::And(cell, hn::Set(di, 31)));
    const auto needed = hn::Ne(hn::And(bits, hn::Set(di, 1)), hn::Zero(di));
    hn::StoreU(hn::DemoteTo(d16, hn::Compress(packed, needed)), d16, position + count);
    hn::StoreU(hn::Compress(hn::LoadU(d, c + n), hn::RebindMask(d, needed)), d, coefficient + count);
    count += static_cast<uint32_t>(hn::CountTrue(di, needed));
  }
  for (; n < brick.count; ++n) {
    const unsigned cell = fine_cell(from[n]);
    if (!(cells[cell >> 6] >> (cell & 63) & 1)) continue;
    position[count] = from[n], coefficient[count++] = c[n];
  }
  return count;
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Within);
HWY_EXPORT(Take);

FineCells cells_within(const FineCube& cube, const FineBall& ball) {
  FineCells cells;
  HWY_DYNAMIC_DISPATCH(Within)(cube, ball, cells);
  return cells;
}

uint32_t take_points(const SplatPoints& points, const SplatBrick& brick, const FineCells& cells,
                     uint16_t* position, float* coefficient) {
  if (cells == FineCells{}) return 0;
  return HWY_DYNAMIC_DISPATCH(Take)(points, brick, cells, position, coefficient);
}

} // namespace bccsplat
#endif
