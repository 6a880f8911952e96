// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/axis/lowpass_row.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <cfloat>
#include <cmath>
#include <cstddef>

#include "fit/axis/lowpass_row.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

void LowpassRow(const float* HWY_RESTRICT v, const float* const* HWY_RESTRICT q,
                const float* HWY_RESTRICT weight, size_t count, size_t n, float* HWY_RESTRICT out) {
  for (size_t x = 0; x < n; x += 16) {
    float sum[16] = {}, four[16];
    for (size_t i = 0; i < 16; ++i) four[i] = 4 * v[x + i];
    for (size_t k = 0; k < count; ++k) {
      const float *a = q[4 * k] + x, *b = q[4 * k + 1] + x, *c = q[4 * k + 2] + x, *d = q[4 * k + 3] + x;
      const float w = weight[k];
      for (size_t i = 0; i < 16; ++i) sum[i] += w * ((a[i] + b[i]) + (c[i] + d[i]) - four[i]);
    }
    for (size_t i = 0; i < 16; ++i) {
      const float r = v[x + i] + sum[i];
      out[x + i] = std::fabs(r) <= FLT_MAX ? r : v[x + i];
    }
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(LowpassRow);

void lowpass_row(const float* v, const float* const* q, const float* weight, size_t count, size_t n,
                 float* out) {
  HWY_DYNAMIC_DISPATCH(LowpassRow)(v, q, weight, count, n, out);
}

} // namespace bccsplat
#endif
