// SPDX-License-Identifier: Apache-2.0
// A point's weights on a vector of samples, for the target being compiled; the file is included once per
// target.
#if defined(BCCSPLAT_SPLAT_WEIGHTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SPLAT_WEIGHTS_INL_H
#undef BCCSPLAT_SPLAT_WEIGHTS_INL_H
#else
#define BCCSPLAT_SPLAT_WEIGHTS_INL_H
#endif

#include <hwy/highway.h>

#include "splat/loop/loops.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

#if HWY_TARGET != HWY_SCALAR

using D = hn::CappedTag<float, 16>; // 4 sheets x 4, 2 or 1 pixels
using V = hn::Vec<D>;
constexpr D d;
HWY_INLINE int PixelsPerVector() { return static_cast<int>(hn::Lanes(d)) / 4; }

// Four sheets, repeated for every pixel of a vector.
HWY_INLINE V Repeat4(const float* p) { return hn::LoadDup128(d, p); }

alignas(64) constexpr float lane_pixel[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

// sum + c phi(u), and c phi'(u) beside it, u >= 0; the coefficient c is multiplied in beforehand.
template<KernelPolynomial::Form> struct Weights;

// u^2 (a2 + u^2 (a4 + a5 u)): four multiplications per vector.
template<> struct Weights<KernelPolynomial::Form::short_form> {
  V a2, a4, a5;
  HWY_INLINE Weights(const KernelPolynomial& k, float c)
      : a2(hn::Set(d, c * k.a[2])), a4(hn::Set(d, c * k.a[4])), a5(hn::Set(d, c * k.a[5])) {}
  HWY_INLINE V add(V u, V sum) const {
    const V w = hn::Mul(u, u);
    return hn::MulAdd(hn::MulAdd(hn::MulAdd(a5, u, a4), w, a2), w, sum);
  }
  // slope = u (2 a2 + u^2 (4 a4 + 5 a5 u))
  HWY_INLINE V add(V u, V sum, V& slope) const {
    const V w = hn::Mul(u, u), q1 = hn::MulAdd(a5, u, a4), q = hn::MulAdd(q1, w, a2);
    const V d1 = hn::MulSub(hn::Set(d, 5.0f), q1, a4);
    slope = hn::Mul(u, hn::MulAdd(d1, w, hn::Add(a2, a2)));
    return hn::MulAdd(q, w, sum);
  }
};

// u^2 (a2 + a4 u^2): three multiplications.
template<> struct Weights<KernelPolynomial::Form::flat_form> {
  V a2, a4;
  HWY_INLINE Weights(const KernelPolynomial& k, float c)
      : a2(hn::Set(d, c * k.a[2])), a4(hn::Set(d, c * k.a[4])) {}
  HWY_INLINE V add(V u, V sum) const {
    const V w = hn::Mul(u, u);
    return hn::MulAdd(hn::MulAdd(a4, w, a2), w, sum);
  }
  // slope = 2 u (a2 + 2 a4 u^2)
  HWY_INLINE V add(V u, V sum, V& slope) const {
    const V w = hn::Mul(u, u), q = hn::MulAdd(a4, w, a2);
    slope = hn::Mul(hn::Add(u, u), hn::MulAdd(a4, w, q));
    return hn::MulAdd(q, w, sum);
  }
};

// u^2 ((a2 + a3 u) + u^2 ((a4 + a5 u) + u^2 (a6 + a7 u))): all radial kernels.
template<> struct Weights<KernelPolynomial::Form::square_8> {
  V a2, a3, a4, a5, a6, a7;
  HWY_INLINE Weights(const KernelPolynomial& k, float c)
      : a2(hn::Set(d, c * k.a[2])), a3(hn::Set(d, c * k.a[3])), a4(hn::Set(d, c * k.a[4])),
        a5(hn::Set(d, c * k.a[5])), a6(hn::Set(d, c * k.a[6])), a7(hn::Set(d, c * k.a[7])) {}
  HWY_INLINE V add(V u, V sum) const {
    const V q0 = hn::MulAdd(a3, u, a2), q1 = hn::MulAdd(a5, u, a4), q2 = hn::MulAdd(a7, u, a6);
    const V w = hn::Mul(u, u);
    return hn::MulAdd(hn::MulAdd(hn::MulAdd(q2, w, q1), w, q0), w, sum);
  }
  // slope = u (2 a2 + 3 a3 u + u^2 (4 a4 + 5 a5 u + u^2 (6 a6 + 7 a7 u)))
  HWY_INLINE V add(V u, V sum, V& slope) const {
    const V q0 = hn::MulAdd(a3, u, a2), q1 = hn::MulAdd(a5, u, a4), q2 = hn::MulAdd(a7, u, a6);
    const V w = hn::Mul(u, u);
    const V d0 = hn::MulSub(hn::Set(d, 3.0f), q0, a2), d1 = hn::MulSub(hn::Set(d, 5.0f), q1, a4);
    const V d2 = hn::MulSub(hn::Set(d, 7.0f), q2, a6);
    slope = hn::Mul(u, hn::MulAdd(hn::MulAdd(d2, w, d1), w, d0));
    return hn::MulAdd(hn::MulAdd(hn::MulAdd(q2, w, q1), w, q0), w, sum);
  }
};

// Any polynomial; phi(0) need not vanish.
template<> struct Weights<KernelPolynomial::Form::general> {
  const KernelPolynomial& kernel;
  V c;
  HWY_INLINE Weights(const KernelPolynomial& k, float coefficient) : kernel(k), c(hn::Set(d, coefficient)) {}
  HWY_INLINE V polynomial(const std::array<float, RadialKernel::max_terms>& a, int terms, V u) const {
    V q = hn::Set(d, a[static_cast<size_t>(terms) - 1]);
    for (int j = terms - 2; j >= 0; --j) q = hn::MulAdd(q, u, hn::Set(d, a[j]));
    return hn::IfThenElseZero(hn::Gt(u, hn::Zero(d)), q); // nothing outside the radius
  }
  HWY_INLINE V add(V u, V sum) const { return hn::MulAdd(c, polynomial(kernel.a, kernel.terms, u), sum); }
  HWY_INLINE V add(V u, V sum, V& slope) const {
    slope = hn::Mul(c, polynomial(kernel.slope, kernel.terms - 1, u));
    return add(u, sum);
  }
};

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif
