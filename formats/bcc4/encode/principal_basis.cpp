// SPDX-License-Identifier: Apache-2.0
// Finds the principal components by Jacobi rotations.
#include "formats/bcc4/encode/principal_basis.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/bcc4/encode/row_sums.h"

namespace bccsplat {
namespace {

int16_t rounded(double v) { return static_cast<int16_t>(std::lround(v * basis_unit)); }

// One Jacobi rotation that makes c[p][q] zero.
void rotate(std::vector<double>& c, std::vector<double>& v, int n, int p, int q) {
  const double off = c[p * n + q];
  if (off == 0) return;
  const double theta = (c[q * n + q] - c[p * n + p]) / (2 * off),
               t = (theta >= 0 ? 1 : -1) / (std::fabs(theta) + std::sqrt(theta * theta + 1)),
               cosine = 1 / std::sqrt(t * t + 1), sine = t * cosine;
  const auto turn = [&](double& a, double& b) {
    const double old = a;
    a = cosine * old - sine * b;
    b = sine * old + cosine * b;
  };
  for (int i = 0; i < n; ++i) turn(c[i * n + p], c[i * n + q]);
  for (int i = 0; i < n; ++i) turn(c[p * n + i], c[q * n + i]);
  for (int i = 0; i < n; ++i) turn(v[p * n + i], v[q * n + i]);
}

} // namespace

FrameProducts::FrameProducts(std::span<const float> slab, int count)
    : frames(count), means(size_t(count) * count) {
  constexpr size_t most_samples = 20000; // of a frame, that are counted
  const size_t samples = slab.size() / frames, step = samples / most_samples + 1;
  const size_t counted = (samples - 1) / step + 1;
  std::vector<float> some(counted * frames);
  for (int t = 0; t < frames; ++t)
    for (size_t i = 0; i < counted; ++i) some[t * counted + i] = slab[t * samples + i * step];
  for (int a = 0; a < frames; ++a)
    for (int b = 0; b <= a; ++b) {
      const auto sum = sum_products<double>(some.data() + a * counted, some.data() + b * counted, counted);
      means[a * frames + b] = means[b * frames + a] = sum / static_cast<double>(counted);
    }
}

TimeBasis principal_basis(const FrameProducts& products) {
  constexpr int sweeps = 12;
  const int n = products.frames;
  std::vector<double> c = products.means, v(size_t(n) * n);
  for (int i = 0; i < n; ++i) v[i * n + i] = 1;
  for (int s = 0; s < sweeps; ++s)
    for (int p = 0; p < n; ++p)
      for (int q = p + 1; q < n; ++q) rotate(c, v, n, p, q);
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return c[a * n + a] > c[b * n + b]; });
  TimeBasis basis{n, std::vector<int16_t>(size_t(n) * n)};
  for (int k = 0; k < n; ++k)
    for (int t = 0; t < n; ++t) basis.rows[k * n + t] = rounded(v[order[k] * n + t]);
  return basis;
}

std::vector<double> variances_in(const TimeBasis& basis, const FrameProducts& products) {
  const int n = basis.frames;
  std::vector<double> out(n);
  for (int k = 0; k < n; ++k)
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        out[k] += products.means[a * n + b] * basis.rows[k * n + a] / basis_unit * basis.rows[k * n + b] /
                  basis_unit;
  return out;
}

} // namespace bccsplat
