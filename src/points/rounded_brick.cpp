// SPDX-License-Identifier: Apache-2.0
// Finds the largest magnitude of a brick, and from it the step. Halves go to even numbers on every target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "points/rounded_brick.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "base/page_pool.h"
#include "points/brick.h"
#include "points/rounded_brick.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Line = hn::CappedTag<float, brick_edge>;

float LargestMagnitude(const float* values) {
  const Line d;
  auto most = hn::Zero(d);
  for (size_t i = 0; i < brick_sites; i += hn::Lanes(d))
    most = hn::Max(most, hn::Abs(hn::Load(d, values + i)));
  return hn::GetLane(hn::MaxOfLanes(d, most));
}

void RoundValues(const float* values, float per_step, int16_t* to) {
  const Line d;
  const hn::Rebind<int16_t, Line> narrow;
  const auto scale = hn::Set(d, per_step);
  for (size_t i = 0; i < brick_sites; i += hn::Lanes(d))
    hn::StoreU(hn::DemoteTo(narrow, hn::NearestInt(hn::Mul(hn::Load(d, values + i), scale))), narrow, to + i);
}

void ReadNumbers(const int16_t* from, float step, int width, int height, float* to, std::ptrdiff_t stride) {
  const Line d;
  const hn::Rebind<int16_t, Line> narrow;
  const hn::RebindToSigned<Line> whole;
  const auto scale = hn::Set(d, step);
  for (int y = 0; y < height; ++y, from += brick_edge, to += stride)
    for (size_t x = 0; x < static_cast<size_t>(width); x += hn::Lanes(d)) {
      const auto number = hn::PromoteTo(whole, hn::LoadU(narrow, from + x));
      hn::StoreU(hn::Mul(hn::ConvertTo(d, number), scale), d, to + x);
    }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(LargestMagnitude);
HWY_EXPORT(RoundValues);
HWY_EXPORT(ReadNumbers);

namespace {

constexpr double coarsest_part = 4, finest_part = 256; // of a step of samples
constexpr float largest_number = 32767;

// The power of two that is no more.
float power_below(double x) { return static_cast<float>(std::exp2(std::floor(std::log2(x)))); }

} // namespace

float coarsest_step(double sample_step) { return power_below(sample_step / coarsest_part); }

std::shared_ptr<const RoundedBrick> RoundedBrick::round(const Brick& brick, float coarsest) {
  const float most = HWY_DYNAMIC_DISPATCH(LargestMagnitude)(brick.value.data());
  if (!(most <= coarsest * largest_number)) return nullptr;
  const auto finest = static_cast<float>(coarsest * (coarsest_part / finest_part));
  float step = coarsest;
  while (step > finest && most <= step / 2 * largest_number) step /= 2;
  auto made = make_pooled_for_overwrite<RoundedBrick>();
  made->step_ = step;
  HWY_DYNAMIC_DISPATCH(RoundValues)(brick.value.data(), 1 / step, made->number_.data());
  std::fill_n(made->number_.begin() + brick_sites, beside, int16_t{0});
  made->masks_ = BrickMasks(brick);
  return made;
}

void RoundedBrick::read(const PlanePart& part, float* to, std::ptrdiff_t stride) const {
  HWY_DYNAMIC_DISPATCH(ReadNumbers)
  (number_.data() + (part.plane * brick_edge + part.y) * brick_edge + part.x, step_, part.width, part.height,
   to, stride);
}

uint64_t RoundedBrick::bytes() const { return sizeof *this + masks_.bytes(); }

} // namespace bccsplat
#endif
