// SPDX-License-Identifier: Apache-2.0
// Sums rows of four coefficients as vectors, for all instruction sets; derivatives along y, z and t share the
// loads with the value.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/evaluate/evaluate_quadricubic.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "tests/bench/evaluate/evaluate.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

#if HWY_MAX_BYTES >= 16 && HWY_TARGET != HWY_SCALAR
using Tag = hn::FixedTag<float, 4>;
using Row = hn::Vec<Tag>;
HWY_INLINE Row Load(const float* p) { return hn::LoadU(Tag(), p); }
HWY_INLINE Row All(float v) { return hn::Set(Tag(), v); }
HWY_INLINE Row Times(Row a, Row b) { return hn::Mul(a, b); }
HWY_INLINE Row TimesPlus(Row a, Row b, Row c) { return hn::MulAdd(a, b, c); }
HWY_INLINE float Total(Row a) { return hn::GetLane(hn::SumOfLanes(Tag(), a)); }
#else
struct Row {
  std::array<float, 4> v;
};
HWY_INLINE Row Load(const float* p) { return {{p[0], p[1], p[2], p[3]}}; }
HWY_INLINE Row All(float v) { return {{v, v, v, v}}; }
HWY_INLINE Row Times(Row a, Row b) {
  return {{a.v[0] * b.v[0], a.v[1] * b.v[1], a.v[2] * b.v[2], a.v[3] * b.v[3]}};
}
HWY_INLINE Row TimesPlus(Row a, Row b, Row c) {
  return {{a.v[0] * b.v[0] + c.v[0], a.v[1] * b.v[1] + c.v[1], a.v[2] * b.v[2] + c.v[2],
           a.v[3] * b.v[3] + c.v[3]}};
}
HWY_INLINE float Total(Row a) { return a.v[0] + a.v[1] + a.v[2] + a.v[3]; }
#endif

struct Axis {
  alignas(16) std::array<float, 4> w, dw;
};

template<bool slopes> HWY_INLINE Axis Weigh(float f) {
  const float g = 1 - f;
  Axis a;
  a.w = {g * g * g * (1.0f / 6), 2.0f / 3 - f * f * (1 - 0.5f * f), 2.0f / 3 - g * g * (1 - 0.5f * g),
         f * f * f * (1.0f / 6)};
  if constexpr (slopes) a.dw = {-0.5f * g * g, f * (1.5f * f - 2), g * (2 - 1.5f * g), 0.5f * f * f};
  return a;
}

template<bool slopes>
void Evaluate(const Quadricubic& field, std::span<const Vec4> points, float* values,
              std::array<float, 4>* gradients) {
  const size_t row = field.dims[0], plane = row * field.dims[1], frame = plane * field.dims[2];
  for (size_t n = 0; n < points.size(); ++n) {
    std::array<size_t, 4> first;
    std::array<Axis, 4> axis;
    for (size_t a = 0; a < 4; ++a) {
      const double x = points[n][a];
      const auto i = static_cast<int32_t>(x);
      first[a] = i - 1;
      axis[a] = Weigh<slopes>(static_cast<float>(x - i));
    }
    const float* corner =
        field.coefficients.data() + first[0] + first[1] * row + first[2] * plane + first[3] * frame;
    const Row y0 = All(axis[1].w[0]), y1 = All(axis[1].w[1]), y2 = All(axis[1].w[2]), y3 = All(axis[1].w[3]);
    [[maybe_unused]] Row v0, v1, v2, v3;
    if constexpr (slopes)
      v0 = All(axis[1].dw[0]), v1 = All(axis[1].dw[1]), v2 = All(axis[1].dw[2]), v3 = All(axis[1].dw[3]);
    Row sum = All(0);
    [[maybe_unused]] Row by_y = sum, by_z = sum, by_t = sum;
    for (size_t l = 0; l < 4; ++l) {
      Row volume = All(0);
      [[maybe_unused]] Row volume_y = volume, volume_z = volume;
      for (size_t k = 0; k < 4; ++k) {
        const float* p = corner + l * frame + k * plane;
        const Row r0 = Load(p), r1 = Load(p + row), r2 = Load(p + 2 * row), r3 = Load(p + 3 * row);
        const Row wz = All(axis[2].w[k]);
        // Two chains of two: the sums of a plane do not wait for each other.
        const Row low = TimesPlus(y1, r1, Times(y0, r0)), high = TimesPlus(y3, r3, Times(y2, r2));
        volume = TimesPlus(wz, low, volume);
        volume = TimesPlus(wz, high, volume);
        if constexpr (slopes) {
          const Row steep = TimesPlus(v3, r3, TimesPlus(v2, r2, TimesPlus(v1, r1, Times(v0, r0))));
          volume_y = TimesPlus(wz, steep, volume_y);
          const Row dz = All(axis[2].dw[k]);
          volume_z = TimesPlus(dz, high, TimesPlus(dz, low, volume_z));
        }
      }
      const Row wt = All(axis[3].w[l]);
      sum = TimesPlus(wt, volume, sum);
      if constexpr (slopes) {
        by_y = TimesPlus(wt, volume_y, by_y), by_z = TimesPlus(wt, volume_z, by_z);
        by_t = TimesPlus(All(axis[3].dw[l]), volume, by_t);
      }
    }
    const Row x = Load(axis[0].w.data());
    values[n] = Total(Times(x, sum));
    if constexpr (slopes)
      gradients[n] = {Total(Times(Load(axis[0].dw.data()), sum)), Total(Times(x, by_y)),
                      Total(Times(x, by_z)), Total(Times(x, by_t))};
  }
}

} // namespace

void EvaluateQuadricubic(const Quadricubic& field, std::span<const Vec4> points, float* values,
                         std::array<float, 4>* gradients) {
  gradients ? Evaluate<true>(field, points, values, gradients)
            : Evaluate<false>(field, points, values, gradients);
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat::bench {
HWY_EXPORT(EvaluateQuadricubic);

void evaluate_quadricubic(const Quadricubic& field, std::span<const Vec4> points, float* values,
                          std::array<float, 4>* gradients) {
  HWY_DYNAMIC_DISPATCH(EvaluateQuadricubic)(field, points, values, gradients);
}

} // namespace bccsplat::bench
#endif
