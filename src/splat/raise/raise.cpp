// SPDX-License-Identifier: Apache-2.0
// Computes the weights that raise.h defines, once per axis of a picture, and holds the reference loops.
#include "splat/raise/raise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/grid.h"

namespace bccsplat {
namespace {

// Integral over x from 0 to 1 of (1 - x)^2 cos(a x).
double falling_wave(double a) {
  return std::fabs(a) < 0.02 ? 1.0 / 3 - a * a / 60 : 2 * (a - std::sin(a)) / (a * a * a);
}

// The linear map from the right-hand sides of the normal equations to the weights.
struct Normal {
  std::array<std::array<double, most_taps + 1>, most_taps> row{};

  // Gauss-Jordan, of the equations with the multiplier that keeps the sum of the weights at 1.
  Normal(int taps, double band) {
    constexpr size_t most = most_taps + 1;
    const size_t n = taps;
    std::array<std::array<double, 2 * most>, most> a{};
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j < n; ++j)
        a[i][j] =
            falling_wave(2 * std::numbers::pi * band * (static_cast<double>(i) - static_cast<double>(j)));
      a[i][n] = a[n][i] = 1;
    }
    for (size_t i = 0; i <= n; ++i) a[i][most + i] = 1;
    for (size_t c = 0; c <= n; ++c) {
      size_t pivot = c;
      for (size_t r = c; r <= n; ++r)
        if (std::fabs(a[r][c]) > std::fabs(a[pivot][c])) pivot = r;
      std::swap(a[c], a[pivot]);
      const double scale = 1 / a[c][c];
      for (double& x : a[c]) x *= scale;
      for (size_t r = 0; r <= n; ++r) {
        if (r == c) continue;
        const double f = a[r][c];
        for (size_t k = 0; k < 2 * most; ++k) a[r][k] -= f * a[c][k];
      }
    }
    for (size_t i = 0; i < n; ++i)
      for (size_t j = 0; j <= n; ++j) row[i][j] = a[i][most + j];
  }

  void weights(int taps, double band, double phase, double* weight) const {
    std::array<double, most_taps + 1> right{};
    const size_t n = taps;
    for (size_t i = 0; i < n; ++i)
      right[i] =
          falling_wave(2 * std::numbers::pi * band * (static_cast<double>(i) - (taps / 2 - 1) - phase));
    right[n] = 1;
    for (size_t i = 0; i < n; ++i) {
      weight[i] = 0;
      for (size_t j = 0; j <= n; ++j) weight[i] += row[i][j] * right[j];
    }
  }
};

} // namespace

void raise_weights(int taps, double band, double phase, double* weight) {
  Normal(taps, band).weights(taps, band, phase, weight);
}

RaiseAxis make_raise_axis(double ratio, double density, int taps, int first, int count, double offset) {
  constexpr double edge = 0.5; // of the band, cycles per T
  const double band = edge / density;
  const Normal normal(taps, band);
  RaiseAxis axis;
  axis.ratio = ratio, axis.offset = offset, axis.first = first;
  axis.pitch = static_cast<size_t>(count) + 16;
  axis.sample.resize(axis.pitch);
  axis.weight.resize(axis.pitch * taps);
  std::array<double, most_taps> weight{};
  for (size_t n = 0; n < axis.pitch; ++n) {
    const double pixel = first + static_cast<double>(std::min(n, static_cast<size_t>(count) - 1));
    const double place = (pixel - offset) / ratio;
    const double whole = std::floor(place);
    axis.sample[n] = static_cast<int32_t>(whole) - (taps / 2 - 1);
    normal.weights(taps, band, place - whole, weight.data());
    for (int t = 0; t < taps; ++t) axis.weight[t * axis.pitch + n] = static_cast<float>(weight[t]);
  }
  return axis;
}

void blend_reference(const BlendArgs& a) {
  for (int y = a.y0; y < a.y1; ++y)
    for (int x = a.x0; x < a.x1; ++x) {
      float sum = 0;
      for (int t = 0; t < a.taps; ++t) sum += a.weight[t] * a.plane[t][plane_offset(x, y, a.pitch)];
      a.out[plane_offset(x, y, a.out_pitch)] = sum;
    }
}

void raise_reference(const RaiseArgs& a) {
  for (int y = a.y0; y < a.y1; ++y)
    for (int x = a.x0; x < a.x1; ++x) {
      float sum = 0;
      for (int i = 0; i < a.taps; ++i) {
        float down = 0;
        for (int j = 0; j < a.taps; ++j) {
          const std::ptrdiff_t row = a.sample_y[y] - a.origin_y + j;
          down += a.weight_y[j * a.weight_pitch_y + y] *
                  a.sheet[row * a.sheet_pitch + a.sample_x[x] - a.origin_x + i];
        }
        sum += a.weight_x[i * a.weight_pitch_x + x] * down;
      }
      a.plane[plane_offset(x, y, a.plane_pitch)] = sum;
    }
}

} // namespace bccsplat
