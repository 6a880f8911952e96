// SPDX-License-Identifier: Apache-2.0
#include "splat/raise/raise_fan.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

int whole(double x) { return static_cast<int>(std::clamp(x, -1e9, 1e9)); }

} // namespace

void make_fan_weights(RaiseFan& fan, double density) {
  // Pixel n of this axis lies n / phases beyond sample 0.
  const RaiseAxis axis = make_raise_axis(RaiseFan::phases, density, fan.taps, 0, RaiseFan::phases);
  fan.weight.assign(size_t{RaiseFan::phases} * most_taps, 0);
  for (size_t n = 0; n < RaiseFan::phases; ++n)
    for (size_t t = 0; t < static_cast<size_t>(fan.taps); ++t)
      fan.weight[n * most_taps + t] = axis.weight[t * axis.pitch + n];
}

void fan_axis(const RaiseFan& fan, const RaiseFan::Axis& axis, double scale, int first, int count,
              RaiseAxis& out) {
  // Places are counted in units of 2^-32 samples, so that sums of them are exact, wherever they start.
  constexpr int bits = 32, rest = bits - RaiseFan::phase_bits;
  const double unit = std::ldexp(1.0, bits), slope = scale * axis.per;
  const int64_t step = std::llround(slope * unit);
  const int64_t zero = std::llround(-axis.foot * slope * unit);
  out.ratio = 1 / slope, out.first = first;
  out.pitch = static_cast<size_t>(count) + 16;
  out.sample.resize(out.pitch);
  out.weight.resize(out.pitch * fan.taps);
  int64_t place = zero + first * step + (int64_t{1} << (rest - 1)); // to the nearest phase
  const int before = fan.taps / 2 - 1;
  for (size_t n = 0; n < out.pitch; ++n) {
    const auto phase = static_cast<size_t>(place >> rest & (RaiseFan::phases - 1));
    const float* const weight = &fan.weight[phase * most_taps];
    out.sample[n] = static_cast<int32_t>(place >> bits) - before;
    for (size_t t = 0; t < static_cast<size_t>(fan.taps); ++t) out.weight[t * out.pitch + n] = weight[t];
    if (n + 1 < static_cast<size_t>(count)) place += step;
  }
}

IntRange fan_samples(const RaiseFan& fan, const RaiseFan::Axis& axis, const Scales& scales,
                     const IntRange& pixel) {
  const double a = (pixel[0] - fan.border - axis.foot) * axis.per,
               b = (pixel[1] - 1 + fan.border - axis.foot) * axis.per;
  const double low = std::min(a * scales[0], a * scales[1]), high = std::max(b * scales[0], b * scales[1]);
  return {whole(std::floor(low)) - fan.taps / 2, whole(std::floor(high)) + fan.taps / 2 + 2};
}

IntRange fan_pixels(const RaiseFan& fan, const RaiseFan::Axis& axis, const Scales& scales,
                    const IntRange& sample) {
  const double a = (sample[0] - 1 - fan.taps / 2) / axis.per, b = (sample[1] + fan.taps / 2) / axis.per;
  const double low = std::min(a / scales[0], a / scales[1]), high = std::max(b / scales[0], b / scales[1]);
  return {whole(std::floor(low + axis.foot)) - fan.border,
          whole(std::ceil(high + axis.foot)) + fan.border + 1};
}

} // namespace bccsplat
