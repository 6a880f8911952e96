// SPDX-License-Identifier: Apache-2.0
// Makes float polynomials of radial kernels for the inner loops.
#include "splat/loop/loops.h"

namespace bccsplat {
namespace {

KernelPolynomial from_kernel(const RadialKernel& kernel, KernelPolynomial::Form form) {
  KernelPolynomial k;
  k.form = form, k.terms = kernel.terms;
  for (size_t j = 0; j < static_cast<size_t>(kernel.terms); ++j) {
    k.a[j] = static_cast<float>(kernel.a[j]);
    if (j > 0) k.slope[j - 1] = static_cast<float>(static_cast<double>(j) * kernel.a[j]);
  }
  return k;
}

} // namespace

KernelPolynomial kernel_polynomial(const RadialKernel& phi, KernelForm form) {
  using Form = KernelPolynomial::Form;
  if (form == KernelForm::short_form)
    if (const auto kernel = short_kernel(phi)) return from_kernel(*kernel, Form::short_form);
  if (form == KernelForm::flat_form)
    if (const auto kernel = flat_kernel(phi)) return from_kernel(*kernel, Form::flat_form);
  return from_kernel(phi, is_square_8(phi) ? Form::square_8 : Form::general);
}

} // namespace bccsplat
