#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4_spread.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "formats/bcc4_spread.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void Spread(const BrickMask& kept, const float* values, float* brick) {
  const hn::CappedTag<float, brick_edge> d;
  const hn::RebindToSigned<decltype(d)> di;
  alignas(64) static constexpr int32_t bit[brick_edge] = {1,   2,   4,    8,    16,   32,   64,    128,
                                                          256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
  for (const unsigned row : kept) {
    const unsigned run = row >> (std::countr_zero(row) & 31);
    if ((run & (run + 1)) == 0) {
      // One run, or none: sixteen values, those beside it cleared.
      const float* from = values - (std::countr_zero(row) & 15);
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
        const auto here = hn::TestBit(hn::Set(di, static_cast<int32_t>(row)), hn::Load(di, bit + x));
        hn::Store(hn::IfThenElseZero(hn::RebindMask(d, here), hn::LoadU(d, from + x)), d, brick + x);
      }
      values += std::bit_width(run);
    } else {
      std::fill_n(brick, brick_edge, 0.0f);
      for (unsigned bits = row; bits; bits &= bits - 1) brick[std::countr_zero(bits)] = *values++;
    }
    brick += brick_edge;
  }
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Spread);

void spread_values(const BrickMask& kept, const float* values, std::span<float, brick_sites> brick) {
  HWY_DYNAMIC_DISPATCH(Spread)(kept, values, brick.data());
}

} // namespace bccsplat
#endif
