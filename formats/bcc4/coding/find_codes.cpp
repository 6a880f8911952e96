// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/find_codes.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>

#include "formats/bcc4/coding/find_codes.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// The code whose value a number is, where there is one, by a multiplication: faster than rounding to the
// nearest as a coder does.
class CodeFinder {
 public:
  explicit CodeFinder(const SampleCoder& coder)
      : scale_(coder.scale()), bias_(coder.bias()), per_scale_(1 / coder.scale()),
        most_(coder.codes().mask()) {}

  // Finds the codes of a full row; returns whether they give all its values back.
  HWY_INLINE bool row(const float* values, uint16_t* codes) const {
    const hn::CappedTag<double, brick_edge> wide;
    const hn::Rebind<float, decltype(wide)> d;
    const hn::Rebind<int32_t, decltype(wide)> whole;
    const hn::Rebind<uint16_t, decltype(wide)> narrow;
    const hn::RebindToUnsigned<decltype(d)> bits;
    bool same = true;
    for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
      const auto value = hn::LoadU(d, values + x);
      const auto from = hn::Sub(hn::PromoteTo(wide, value), hn::Set(wide, bias_));
      const auto steps = hn::Add(hn::Mul(from, hn::Set(wide, per_scale_)), hn::Set(wide, 0.5));
      const auto inside =
          hn::Min(hn::IfThenElseZero(hn::Gt(steps, hn::Zero(wide)), steps), hn::Set(wide, most_));
      const auto found = hn::DemoteTo(whole, inside);
      const auto again =
          hn::Add(hn::Mul(hn::PromoteTo(wide, found), hn::Set(wide, scale_)), hn::Set(wide, bias_));
      hn::StoreU(hn::DemoteTo(narrow, found), narrow, codes + x);
      same &= hn::AllTrue(bits, hn::Eq(hn::BitCast(bits, hn::DemoteTo(d, again)), hn::BitCast(bits, value)));
    }
    return same;
  }
  // Finds the code of one site.
  HWY_INLINE bool site(float value, uint16_t& code) const {
    const double steps = (value - bias_) * per_scale_ + 0.5;
    const double inside = steps > 0 ? (steps < most_ ? steps : most_) : 0;
    const auto found = static_cast<int32_t>(inside);
    code = static_cast<uint16_t>(found);
    return std::bit_cast<uint32_t>(static_cast<float>(found * scale_ + bias_)) ==
           std::bit_cast<uint32_t>(value);
  }

 private:
  double scale_, bias_, per_scale_, most_;
};

size_t FindCodes(const SampleCoder& coder, const Brick& brick, uint16_t* HWY_RESTRICT codes) {
  const CodeFinder finder(coder);
  size_t count = 0;
  for (size_t row = 0; row < brick_rows; ++row) {
    const float* values = brick.value.data() + row * brick_edge;
    const unsigned kept = brick.kept[row];
    bool same = true;
    if (kept == 0xffff) {
      same = finder.row(values, codes + count);
      count += brick_edge;
    } else {
      for (unsigned bits = kept; bits; bits &= bits - 1)
        same &= finder.site(values[std::countr_zero(bits)], codes[count++]);
    }
    if (!same) return 0;
  }
  return count;
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(FindCodes);

size_t find_codes(const SampleCoder& coder, const Brick& brick, std::span<uint16_t, brick_sites> codes) {
  return HWY_DYNAMIC_DISPATCH(FindCodes)(coder, brick, codes.data());
}

} // namespace bccsplat
#endif
