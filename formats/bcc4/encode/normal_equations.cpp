// SPDX-License-Identifier: Apache-2.0
// Sums products in vectors and solves the equations.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/encode/normal_equations.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "formats/bcc4/encode/normal_equations.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

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

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(AddSamples);

namespace {

// This share of the diagonal is added to it, so that weights which the sample does not determine shrink to 0.
constexpr double ridge = 1e-4;

} // namespace

void add_samples(NormalEquations& equations, std::span<const double> samples, size_t n) {
  HWY_DYNAMIC_DISPATCH(AddSamples)(equations, samples, n);
}

// Cholesky's method.
Weights solve(LeastSquares e, size_t n) {
  for (size_t i = 0; i < n; ++i) e.a[i][i] += ridge * e.a[i][i] + 1;
  for (size_t j = 0; j < n; ++j) {
    for (size_t k = 0; k < j; ++k) e.a[j][j] -= e.a[j][k] * e.a[j][k];
    e.a[j][j] = std::sqrt(std::max(e.a[j][j], 1e-300));
    for (size_t i = j + 1; i < n; ++i) {
      for (size_t k = 0; k < j; ++k) e.a[i][j] -= e.a[i][k] * e.a[j][k];
      e.a[i][j] /= e.a[j][j];
    }
  }
  std::array<double, max_taps> w = e.b;
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) w[i] -= e.a[i][k] * w[k];
    w[i] /= e.a[i][i];
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; ++k) w[i] -= e.a[k][i] * w[k];
    w[i] /= e.a[i][i];
  }
  constexpr double one = 1 << fraction_bits;
  const auto room = INT16_MAX - static_cast<double>(n); // for rounding
  double sum = 0;
  for (size_t i = 0; i < n; ++i) sum += std::fabs(w[i]);
  const double scale = sum * one <= room ? one : room / sum;
  Weights q{};
  for (size_t i = 0; i < n; ++i)
    q[i] = static_cast<int16_t>(
        std::clamp(std::floor(w[i] * scale + 0.5), -double{INT16_MAX}, double{INT16_MAX}));
  return q;
}

} // namespace bccsplat
#endif
