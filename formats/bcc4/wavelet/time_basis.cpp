// SPDX-License-Identifier: Apache-2.0
// Cosines, the principal components of frames by Jacobi rotations, and the change to either.
#include "formats/bcc4/wavelet/time_basis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "formats/bcc4/wavelet/layer_sums.h"

namespace bccsplat {
namespace {

int16_t rounded(double v) { return static_cast<int16_t>(std::lround(v * basis_unit)); }

constexpr size_t most_samples = 20000; // of a frame, that are counted
size_t sample_step(size_t samples) { return samples / most_samples + 1; }
size_t counted_samples(size_t samples) { return (samples - 1) / sample_step(samples) + 1; }

// Sums of products of frames, from some of their samples.
std::vector<double> covariance(std::span<const float> slab, int frames) {
  const size_t samples = slab.size() / frames, step = sample_step(samples);
  std::vector<double> c(size_t(frames) * frames);
  for (int a = 0; a < frames; ++a)
    for (int b = 0; b <= a; ++b) {
      double sum = 0;
      for (size_t i = 0; i < samples; i += step) sum += double{slab[a * samples + i]} * slab[b * samples + i];
      c[a * frames + b] = c[b * frames + a] = sum;
    }
  return c;
}

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

// Makes each layer of a slab the sum of all, in place, some samples at a time.
void change_basis(int layers, std::span<float> slab, const std::vector<float>& weights) {
  constexpr size_t block = 256;
  const size_t samples = slab.size() / layers;
  std::vector<float> out(block * layers);
  std::vector<WeighedLayer> sum;
  for (size_t first = 0; first < samples; first += block) {
    const size_t n = std::min(block, samples - first);
    for (int to = 0; to < layers; ++to) {
      sum.clear();
      for (int k = 0; k < layers; ++k) sum.push_back({slab.data() + k * samples, weights[to * layers + k]});
      sum_layers(sum, first, n, out.data() + to * block);
    }
    for (int to = 0; to < layers; ++to)
      std::copy_n(out.data() + to * block, n, slab.data() + to * samples + first);
  }
}

// What leads to the layers that rows B of nearly an orthogonal matrix make frames of: one step of Newton's
// from them, 2 B - B B^T B.
std::vector<float> inverse_of(int n, const std::vector<float>& rows) {
  std::vector<float> inverse;
  for (int k = 0; k < n; ++k) {
    std::vector<double> row(rows.begin() + k * n, rows.begin() + (k + 1) * n);
    for (double& v : row) v *= 2;
    for (int j = 0; j < n; ++j) {
      double product = 0;
      for (int t = 0; t < n; ++t) product += double{rows[k * n + t]} * rows[j * n + t];
      for (int t = 0; t < n; ++t) row[t] -= product * rows[j * n + t];
    }
    inverse.insert(inverse.end(), row.begin(), row.end());
  }
  return inverse;
}

} // namespace

TimeBasis cosine_basis(int frames) {
  TimeBasis basis{frames, std::vector<int16_t>(size_t(frames) * frames)};
  for (int k = 0; k < frames; ++k)
    for (int t = 0; t < frames; ++t)
      basis.rows[k * frames + t] =
          rounded(std::sqrt((k ? 2.0 : 1.0) / frames) * std::cos(std::numbers::pi * k * (t + .5) / frames));
  return basis;
}

TimeBasis principal_basis(std::span<const float> slab, int frames) {
  constexpr int sweeps = 12;
  const int n = frames;
  std::vector<double> c = covariance(slab, n), v(size_t(n) * n);
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

std::vector<double> variances_in(const TimeBasis& basis, std::span<const float> slab) {
  const int n = basis.frames;
  const std::vector<double> c = covariance(slab, n);
  const double samples = static_cast<double>(counted_samples(slab.size() / n));
  std::vector<double> out(n);
  for (int k = 0; k < n; ++k) {
    double sum = 0;
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        sum += c[a * n + b] * basis.rows[k * n + a] / basis_unit * basis.rows[k * n + b] / basis_unit;
    out[k] = sum / samples;
  }
  return out;
}

void to_layers(const TimeBasis& basis, std::span<float> slab, bool exactly) {
  std::vector<float> weights;
  for (int layer = 0; layer < basis.frames; ++layer)
    for (int frame = 0; frame < basis.frames; ++frame) weights.push_back(basis.weight(layer, frame));
  change_basis(basis.frames, slab, exactly ? inverse_of(basis.frames, weights) : weights);
}

} // namespace bccsplat
