#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/normal_equations.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "formats/bcc4/coding/normal_equations.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Four rows of the sums at a time are kept in registers.
void AddSamples(NormalEquations& equations, std::span<const double> samples, size_t n) {
  constexpr size_t columns = NormalEquations::columns;
  const hn::CappedTag<double, columns> d;
  const double* const begin = samples.data();
  const double* const end = begin + samples.size();
  for (size_t i = 0; i <= n; i += 4) {
    std::array<double, columns>* const sum = &equations.sum[i];
    for (size_t j = 0; j < i + 4; j += hn::Lanes(d)) {
      auto s0 = hn::LoadU(d, &sum[0][j]), s1 = hn::LoadU(d, &sum[1][j]), s2 = hn::LoadU(d, &sum[2][j]),
           s3 = hn::LoadU(d, &sum[3][j]);
      for (const double* v = begin; v != end; v += columns) {
        const auto other = hn::LoadU(d, v + j);
        s0 = hn::Add(s0, hn::Mul(other, hn::Set(d, v[i])));
        s1 = hn::Add(s1, hn::Mul(other, hn::Set(d, v[i + 1])));
        s2 = hn::Add(s2, hn::Mul(other, hn::Set(d, v[i + 2])));
        s3 = hn::Add(s3, hn::Mul(other, hn::Set(d, v[i + 3])));
      }
      hn::StoreU(s0, d, &sum[0][j]);
      hn::StoreU(s1, d, &sum[1][j]);
      hn::StoreU(s2, d, &sum[2][j]);
      hn::StoreU(s3, d, &sum[3][j]);
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(AddSamples);

void add_samples(NormalEquations& equations, std::span<const double> samples, size_t n) {
  HWY_DYNAMIC_DISPATCH(AddSamples)(equations, samples, n);
}

} // namespace bccsplat
#endif
