// SPDX-License-Identifier: Apache-2.0
// A small series in memory, a fit of it, and the same resampling as a slow double-precision sum.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "fit/fit.h"
#include "tests/support/larger.h"
#include "tests/unit/base/bench.h"

namespace bccsplat::test {

struct Series {
  std::array<uint32_t, 4> dims{1, 1, 1, 1};
  std::vector<float> values; // x fastest

  Series() = default;
  Series(std::array<uint32_t, 4> n, const std::function<double(double, double, double, double)>& f)
      : dims(n) {
    for (uint32_t t = 0; t < n[3]; ++t)
      for (uint32_t z = 0; z < n[2]; ++z)
        for (uint32_t y = 0; y < n[1]; ++y)
          for (uint32_t x = 0; x < n[0]; ++x) values.push_back(static_cast<float>(f(x, y, z, t)));
  }
  [[nodiscard]] size_t frame_samples() const { return size_t{dims[0]} * dims[1] * dims[2]; }
  [[nodiscard]] float at(int64_t x, int64_t y, int64_t z, int64_t t) const {
    return values[((t * dims[2] + z) * dims[1] + y) * dims[0] + x];
  }
  [[nodiscard]] std::span<const float> frame(uint32_t t) const {
    return {values.data() + t * frame_samples(), frame_samples()};
  }
  [[nodiscard]] FrameBox box(uint32_t t) const {
    FrameBox b;
    b.data = frame(t).data();
    b.type = SourceType::f32;
    for (size_t a = 0; a < 3; ++a) b.dims[a] = dims[a];
    return b;
  }
};

inline Series noise(std::array<uint32_t, 4> dims, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return Series(dims, [&](double, double, double, double) { return uniform(random); });
}

struct Fitted {
  FitReport report;
  std::vector<BrickLayer> layers; // of channel 0
  [[nodiscard]] std::vector<float> dense(int32_t layer) const { return layer_to_dense(layers[layer]); }
};

// The boxes of frame t.
using Boxes = std::function<std::vector<FrameBox>(uint32_t t)>;

inline Fitted run_fit(FitOptions options, const Boxes& boxes, uint32_t frames, int threads = 1,
                      MaskSink masks = {}) {
  Bench bench(threads);
  Fitted result;
  int32_t next_slab = 0;
  Fit fit(
      options,
      [&](int32_t slab, int channel, std::span<const BrickLayer> layers) {
        if (channel != 0) return;
        if (slab != next_slab++) throw Error(Code::internal, "slabs out of order");
        result.layers.insert(result.layers.end(), layers.begin(), layers.end());
      },
      bench.context, std::move(masks));
  for (uint32_t t = 0; t < frames; ++t) fit.add_frame(0, boxes(t));
  result.report = fit.finish();
  return result;
}

inline FitOptions options_for(const Series& s, LatticeKind kind = LatticeKind::d4star) {
  FitOptions o;
  o.lattice = kind;
  o.dims = s.dims;
  return o;
}

inline Fitted run_fit(const FitOptions& options, const Series& s, int threads = 1, MaskSink masks = {}) {
  return run_fit(
      options, [&](uint32_t t) { return std::vector{s.box(t)}; }, s.dims[3], threads, std::move(masks));
}

// Weight of the sample `distance` away, before they are divided by their sum: the formula of the filter,
// written anew.
inline double reference_weight(double distance) {
  constexpr double half = 4, beta = 5.5;
  const double pi = std::numbers::pi, x = std::fabs(distance);
  if (x >= half) return 0;
  const double sinc = x < 1e-12 ? 1 : std::sin(pi * x) / (pi * x);
  return sinc * std::cyl_bessel_i(0.0, beta * std::sqrt(1 - x * x / half / half)) /
         std::cyl_bessel_i(0.0, beta);
}

// out[i] = the axis `axis` of `in` at `positions`, ends mirrored.
inline std::vector<double> reference_axis(const std::vector<double>& in, std::array<size_t, 4>& n,
                                          size_t axis, const std::vector<double>& positions,
                                          double widening) {
  std::array<size_t, 4> m = n;
  m[axis] = positions.size();
  std::vector<double> out(m[0] * m[1] * m[2] * m[3]);
  const int64_t count = n[axis];
  const auto reach = 4 * static_cast<int64_t>(std::ceil(widening)) + 1;
  for (size_t p = 0; p < positions.size(); ++p) {
    std::vector<double> weight(n[axis], 0.0);
    double sum = 0;
    for (auto j = static_cast<int64_t>(std::floor(positions[p])) - reach;
         j <= static_cast<int64_t>(positions[p]) + reach; ++j) {
      int64_t folded = j;
      while (folded < 0 || folded >= count)
        folded = count == 1 ? 0 : folded < 0 ? -folded : 2 * (count - 1) - folded;
      const double w = reference_weight((positions[p] - static_cast<double>(j)) / widening);
      weight[folded] += w;
      sum += w;
    }
    std::array<size_t, 4> i{};
    for (i[3] = 0; i[3] < (axis == 3 ? 1 : n[3]); ++i[3])
      for (i[2] = 0; i[2] < (axis == 2 ? 1 : n[2]); ++i[2])
        for (i[1] = 0; i[1] < (axis == 1 ? 1 : n[1]); ++i[1])
          for (i[0] = 0; i[0] < (axis == 0 ? 1 : n[0]); ++i[0]) {
            const auto index = [](const std::array<size_t, 4>& q, const std::array<size_t, 4>& s) {
              return ((q[3] * s[2] + q[2]) * s[1] + q[1]) * s[0] + q[0];
            };
            std::array<size_t, 4> from = i, to = i;
            to[axis] = p;
            double value = 0;
            for (from[axis] = 0; from[axis] < n[axis]; ++from[axis])
              value += weight[from[axis]] / sum * in[index(from, n)];
            out[index(to, m)] = value;
          }
  }
  n = m;
  return out;
}

// All layers of the lattice by whole-array sums; values relative to air.
inline std::vector<std::vector<double>> reference_layers(const Lattice4& lattice, const Series& s,
                                                         double air = 0) {
  std::vector<std::vector<double>> layers;
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int c = lattice.coset(m);
    std::array<size_t, 4> n{s.dims[0], s.dims[1], s.dims[2], s.dims[3]};
    std::vector<double> v;
    for (const float f : s.values) v.push_back(f - air);
    for (size_t a = 4; a-- > 0;) {
      std::vector<double> positions;
      double widening = 1;
      if (a == 3) {
        positions = {lattice.is_static() ? 0 : m * lattice.time_step};
        if (!lattice.is_static()) widening = lattice.time_step / lattice.layer_distance();
      } else {
        for (int32_t i = 0; i < lattice.space.dims(c)[a]; ++i)
          positions.push_back(lattice.space.plane(c, i) * lattice.space_step[a]);
        widening = lattice.space_step[a] / lattice.space.plane_distance();
      }
      v = reference_axis(v, n, a, positions, std::max(1.0, widening));
    }
    layers.push_back(std::move(v));
  }
  return layers;
}

// Largest difference of the layers of a fit from a reference.
inline double worst_difference(const Fitted& f, const std::vector<std::vector<double>>& reference) {
  if (f.layers.size() != reference.size()) return INFINITY;
  double worst = 0;
  for (size_t m = 0; m < reference.size(); ++m) {
    const std::vector<float> dense = layer_to_dense(f.layers[m]);
    if (dense.size() != reference[m].size()) return INFINITY;
    for (size_t i = 0; i < dense.size(); ++i) worst = larger(worst, std::fabs(dense[i] - reference[m][i]));
  }
  return worst;
}

// Same sites, same values, same holes.
inline bool identical(const Fitted& a, const Fitted& b) {
  if (!(a.report.lattice == b.report.lattice) || a.layers.size() != b.layers.size()) return false;
  for (size_t m = 0; m < a.layers.size(); ++m)
    for (size_t s = 0; s < a.layers[m].brick_slots(); ++s) {
      const Brick *p = a.layers[m].brick(s), *q = b.layers[m].brick(s);
      if (!p != !q) return false;
      if (!p) continue;
      if (p->kept != q->kept || p->value != q->value || !p->hole != !q->hole) return false;
      if (p->hole && *p->hole != *q->hole) return false;
    }
  return true;
}

} // namespace bccsplat::test
