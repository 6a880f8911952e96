// SPDX-License-Identifier: Apache-2.0
// Products are rounded before they are added, so that every target computes the same coefficients; and sums
// are the same where before and behind are exchanged, so that a mirror image has the bits of its original.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "field/coefficients/stage_plane.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <type_traits>

#include "field/coefficients/stage_plane.h"
#include "points/brick.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Line = hn::CappedTag<float, brick_edge>;

// The weighted sum of `count` planes at an offset.
template<size_t count> HWY_INLINE hn::Vec<Line> Weighted(const PlaneTerms& terms, std::ptrdiff_t at) {
  const Line d;
  auto sum = hn::Mul(hn::Set(d, terms.term[0].weight), hn::LoadU(d, terms.term[0].at + at));
  for (size_t t = 1; t < count; ++t)
    sum = hn::Add(hn::Mul(hn::Set(d, terms.term[t].weight), hn::LoadU(d, terms.term[t].at + at)), sum);
  return sum;
}

template<size_t count> void SumTerms(const PlaneTerms terms, const PlaneBox box, float* to) {
  const Line d;
  for (int y = 0; y < box.height; ++y)
    for (std::ptrdiff_t x = 0; x < box.width; x += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
      const std::ptrdiff_t at = y * box.stride + x;
      hn::StoreU(Weighted<count>(terms, at), d, to + at);
    }
}

// Calls body with the number of terms as a type.
template<size_t n> using Count = std::integral_constant<size_t, n>;
template<class Body> HWY_INLINE void ForCount(size_t count, const Body& body) {
  switch (count) {
  case 1:
    return body(Count<1>());
  case 2:
    return body(Count<2>());
  case 3:
    return body(Count<3>());
  case 4:
    return body(Count<4>());
  case 5:
    return body(Count<5>());
  default:
    return body(Count<6>());
  }
}

template<bool two, int span>
void Corners(const float* first, const float* second, const PlaneBox box, float* to) {
  const Line d;
  const auto pair = [&](std::ptrdiff_t at) HWY_ATTR {
    auto low = hn::LoadU(d, first + at), high = hn::LoadU(d, first + at + span);
    if constexpr (two)
      low = hn::Add(low, hn::LoadU(d, second + at)), high = hn::Add(high, hn::LoadU(d, second + at + span));
    return hn::Add(low, high);
  };
  // Down the rows, so that each pair is summed once.
  for (std::ptrdiff_t x = 0; x < box.width; x += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
    auto before = pair(x), next = pair(x + (span - 1) * box.stride);
    for (int y = 0; y < box.height; ++y) {
      const std::ptrdiff_t at = y * box.stride + x;
      const auto last = pair(at + span * box.stride);
      hn::StoreU(hn::Add(before, last), d, to + at);
      before = span == 1 ? last : next;
      next = last;
    }
  }
}

template<size_t count, bool around, bool cross>
void Stage(const StagePlane p, const PlaneBox box, float* to) {
  const Line d;
  const auto w = hn::Set(d, p.cross);
  for (int y = 0; y < box.height; ++y)
    for (std::ptrdiff_t x = 0; x < box.width; x += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
      const std::ptrdiff_t at = y * box.stride + x;
      auto sum = Weighted<count>(p.centre, at);
      if constexpr (around) {
        const float* c = p.neighbours[1] + at;
        const auto along_x = hn::Add(hn::LoadU(d, c - 1), hn::LoadU(d, c + 1));
        const auto along_y = hn::Add(hn::LoadU(d, c - box.stride), hn::LoadU(d, c + box.stride));
        const auto along_z = hn::Add(hn::LoadU(d, p.neighbours[0] + at), hn::LoadU(d, p.neighbours[2] + at));
        sum = hn::Add(sum, hn::Add(hn::Add(along_x, along_y), along_z));
      }
      if constexpr (cross) {
        const auto eight = hn::Add(hn::LoadU(d, p.corners[0] + at), hn::LoadU(d, p.corners[1] + at));
        sum = hn::Add(hn::Mul(w, eight), sum);
      }
      hn::StoreU(sum, d, to + at);
    }
}

void SumPlanes(const PlaneTerms& terms, const PlaneBox& box, float* to) {
  ForCount(terms.count, [&](auto count) { SumTerms<decltype(count)::value>(terms, box, to); });
}

void SumCorners(const float* first, const float* second, int span, const PlaneBox& box, float* to) {
  if (second)
    span == 1 ? Corners<true, 1>(first, second, box, to) : Corners<true, 2>(first, second, box, to);
  else
    span == 1 ? Corners<false, 1>(first, second, box, to) : Corners<false, 2>(first, second, box, to);
}

void SumStage(const StagePlane& plane, const PlaneBox& box, float* to) {
  const bool around = plane.neighbours[0], cross = plane.corners[0];
  ForCount(plane.centre.count, [&](auto terms) {
    constexpr size_t count = decltype(terms)::value;
    if (around)
      cross ? Stage<count, true, true>(plane, box, to) : Stage<count, true, false>(plane, box, to);
    else
      cross ? Stage<count, false, true>(plane, box, to) : Stage<count, false, false>(plane, box, to);
  });
}

bool KeepPlane(const float* from, const PlaneBox& box, float prune, float* to, uint16_t* kept) {
  const Line d;
  const auto limit = hn::Set(d, prune);
  unsigned any = 0;
  for (int y = 0; y < brick_edge; ++y, to += brick_edge) {
    unsigned bits = 0;
    for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
      if (y >= box.height) {
        hn::StoreU(hn::Zero(d), d, to + x);
        continue;
      }
      const auto v = hn::LoadU(d, from + y * box.stride + x);
      const auto inside = hn::FirstN(d, std::max(0, box.width - static_cast<int>(x)));
      const auto keep = hn::And(inside, hn::Gt(hn::Abs(v), limit));
      hn::StoreU(hn::IfThenElseZero(keep, v), d, to + x);
      std::array<uint8_t, 8> bytes{};
      hn::StoreMaskBits(d, keep, bytes.data());
      bits |= (bytes[0] | static_cast<unsigned>(bytes[1]) << 8) << x;
    }
    kept[y] = static_cast<uint16_t>(bits);
    any |= bits;
  }
  return any != 0;
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(SumPlanes);
HWY_EXPORT(SumCorners);
HWY_EXPORT(SumStage);
HWY_EXPORT(KeepPlane);

void sum_planes(const PlaneTerms& terms, const PlaneBox& box, float* to) {
  HWY_DYNAMIC_DISPATCH(SumPlanes)(terms, box, to);
}
void sum_corners(const float* first, const float* second, int span, const PlaneBox& box, float* to) {
  HWY_DYNAMIC_DISPATCH(SumCorners)(first, second, span, box, to);
}
void sum_stage(const StagePlane& plane, const PlaneBox& box, float* to) {
  HWY_DYNAMIC_DISPATCH(SumStage)(plane, box, to);
}
bool keep_plane(const float* from, const PlaneBox& box, float prune, float* to, uint16_t* kept) {
  return HWY_DYNAMIC_DISPATCH(KeepPlane)(from, box, prune, to, kept);
}

} // namespace bccsplat
#endif
