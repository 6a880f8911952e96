// SPDX-License-Identifier: Apache-2.0
// Fourier transforms of kernels, and responses of prefilters and of sums over the lattice sites.
#include "tests/bench/kernels/kernel_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernel/radial.h"

namespace bccsplat {
namespace {

using std::numbers::pi;
constexpr double coset_pitch = std::numbers::sqrt2; // of a coset, along every axis
constexpr double step = 1.0 / 256;                  // of the tables, cycles per T
constexpr double table_end = 8;

double sinc(double x) { return std::abs(x) < 1e-8 ? 1 : std::sin(pi * x) / (pi * x); }

// Simpson's rule over [0, end]; 512 intervals resolve 2 * 8 * 2.83 half waves to 1e-9 and better.
template<class F> double integrate(double end, F&& f) {
  constexpr int n = 512;
  double sum = f(0.0) + f(end);
  for (int i = 1; i < n; ++i) sum += f(end * i / n) * (i & 1 ? 4 : 2);
  return sum * end / (3 * n);
}

// Cubic Lagrange interpolation of an even function tabulated at multiples of `step`.
double look_up(const std::vector<double>& table, double k) {
  const double x = std::abs(k) / step;
  const auto i = static_cast<size_t>(x);
  if (i + 2 >= table.size()) return 0;
  const double f = x - static_cast<double>(i);
  const double before = table[i == 0 ? 1 : i - 1];
  return before * (-f * (f - 1) * (f - 2) / 6) + table[i] * ((f + 1) * (f - 1) * (f - 2) / 2) +
         table[i + 1] * (-(f + 1) * f * (f - 2) / 2) + table[i + 2] * ((f + 1) * f * (f - 1) / 6);
}

// The taps of a filter by half steps (units of 1/sqrt2) in `axes` dimensions, in a box of the reach of all
// stages.
struct Taps {
  size_t axes;
  int reach;
  std::vector<double> values;

  Taps(size_t axes_, int reach_) : axes(axes_), reach(reach_) {
    size_t count = 1;
    for (size_t a = 0; a < axes; ++a) count *= 2 * reach + 1;
    values.assign(count, 0.0);
    values[count / 2] = 1;
  }
  [[nodiscard]] ptrdiff_t stride(size_t axis) const {
    ptrdiff_t s = 1;
    for (size_t a = 0; a < axis; ++a) s *= 2 * reach + 1;
    return s;
  }
};

// Adds the taps of an own-coset stencil and the cross sum, applied to `from`, to `to`.
void add_stencil(const Taps& shape, const std::vector<double>& from, std::vector<double>& to,
                 const std::array<double, 5>& weights) {
  const auto add = [&](ptrdiff_t offset, double weight) {
    if (weight == 0) return;
    for (size_t i = 0; i < from.size(); ++i)
      if (from[i] != 0) to[static_cast<ptrdiff_t>(i) + offset] += weight * from[i];
  };
  const auto [self, spatial, temporal, mixed, cross] = weights;
  add(0, self);
  for (const int t : {-2, 0, 2}) {
    if (t != 0 && shape.axes < 4) continue;
    const ptrdiff_t layer = t == 0 ? 0 : t * shape.stride(3);
    if (t != 0) add(layer, temporal);
    for (size_t a = 0; a < 3; ++a)
      for (const int sign : {-2, 2}) add(layer + sign * shape.stride(a), t == 0 ? spatial : mixed);
  }
  for (unsigned corner = 0; corner < 1u << shape.axes; ++corner) {
    ptrdiff_t offset = 0;
    for (size_t a = 0; a < shape.axes; ++a) offset += (corner >> a & 1 ? 1 : -1) * shape.stride(a);
    add(offset, cross);
  }
}

double gain(std::span<const PrefilterStage> stages, size_t axes) {
  const Reach reach = prefilter_reach(stages);
  Taps taps(axes, std::max(reach.space, reach.time));
  const std::vector<double> impulse = taps.values;
  for (const PrefilterStage& s : stages) {
    std::vector<double> next(taps.values.size(), 0.0);
    add_stencil(taps, taps.values, next, {s.self, s.spatial, s.temporal, s.mixed, s.cross});
    add_stencil(taps, impulse, next, {s.source, s.source_spatial, s.source_temporal, s.source_mixed, 0.0});
    taps.values.swap(next);
  }
  double sum = 0;
  for (const double t : taps.values) sum += std::abs(t);
  return sum;
}

} // namespace

NeighbourMeans neighbour_means4(const std::array<double, 4>& frequency) {
  double c[4]; // own-coset neighbours are sqrt2 away, the others half of that on every axis
  for (size_t a = 0; a < 4; ++a) c[a] = std::cos(std::numbers::sqrt2 * pi * frequency[a]);
  return {(2 * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) - 3) / 3, 2 * c[3] * c[3] - 1,
          c[0] * c[1] * c[2] * c[3]};
}

NeighbourMeans neighbour_means3(const std::array<double, 3>& frequency) {
  return neighbour_means4({frequency[0], frequency[1], frequency[2], 0.0});
}

double running_symbol(const PrefilterStage& stage, const NeighbourMeans& means, int cross_neighbours) {
  return stage.self + 6 * stage.spatial * means.spatial + 2 * stage.temporal * means.temporal +
         12 * stage.mixed * means.spatial * means.temporal + cross_neighbours * stage.cross * means.cross;
}

double source_symbol(const PrefilterStage& stage, const NeighbourMeans& means) {
  return stage.source + 6 * stage.source_spatial * means.spatial +
         2 * stage.source_temporal * means.temporal +
         12 * stage.source_mixed * means.spatial * means.temporal;
}

double prefilter_symbol(std::span<const PrefilterStage> stages, const NeighbourMeans& means,
                        int cross_neighbours) {
  double q = 1;
  for (const PrefilterStage& stage : stages)
    q = running_symbol(stage, means, cross_neighbours) * q + source_symbol(stage, means);
  return q;
}

double prefilter_gain4(std::span<const PrefilterStage> stages) { return gain(stages, 4); }
double prefilter_gain3(std::span<const PrefilterStage> stages) { return gain(stages, 3); }

KernelSpectrum::KernelSpectrum(const Kernel& kernel) : beta_(kernel.time) {
  const RadialKernel& phi = kernel.space;
  for (const int coset : {0, 1})
    for (int a = -4; a <= 4; ++a)
      for (int b = -4; b <= 4; ++b)
        for (int c = -4; c <= 4; ++c) {
          const std::array<double, 3> p{(a + 0.5 * coset) * coset_pitch, (b + 0.5 * coset) * coset_pitch,
                                        (c + 0.5 * coset) * coset_pitch};
          const double weight = phi.value(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
          if (weight != 0) sites_.push_back({coset, p, weight});
        }
  const double mass = radial_integral(phi);
  const auto size = static_cast<size_t>(table_end / step) + 1;
  space_.resize(size);
  for (size_t i = 0; i < size; ++i) {
    const double k = static_cast<double>(i) * step;
    space_[i] =
        integrate(phi.radius, [&](double r) { return 4 * pi * r * r * phi.value(r * r) * sinc(2 * k * r); }) /
        mass;
  }
  const bool spline = beta_.shape == TemporalKernel::Shape::bspline;
  TemporalKernel straight = beta_;
  straight.bend = {};
  if (spline && beta_.bend == straight.bend) return;
  time_.resize(size);
  for (size_t i = 0; i < size; ++i) {
    const double k = static_cast<double>(i) * step;
    // The value at the cut of a Gaussian counts as inside: the integrand is closed at its end.
    const auto value = [&](double t) {
      return spline ? beta_.value(t) - straight.value(t) : beta_.scale * std::exp(-beta_.gaussian * t * t);
    };
    time_[i] = 2 *
               integrate(beta_.half_width, [&](double t) { return value(t) * std::cos(2 * pi * k * t); }) /
               std::numbers::sqrt2;
  }
}

double KernelSpectrum::space(double k) const { return look_up(space_, k); }

double KernelSpectrum::time(double k) const {
  const double tabulated = time_.empty() ? 0 : look_up(time_, k);
  if (beta_.shape == TemporalKernel::Shape::gaussian) return tabulated;
  return std::pow(sinc(std::numbers::sqrt2 * k), beta_.order) + tabulated;
}

double KernelSpectrum::symbol(const std::array<double, 4>& xi, int dimensions) const {
  std::array<double, 2> layers{1, 1}; // by coset: the sum over its layers
  if (dimensions == 4)
    for (const int coset : {0, 1}) {
      double sum = 0;
      for (int k = -3; k <= 3; ++k) {
        const double t = (k + 0.5 * coset) * coset_pitch;
        sum += beta_.value(t) * std::cos(2 * pi * xi[3] * t);
      }
      layers[coset] = sum;
    }
  double sum = 0;
  for (const Site& s : sites_) {
    const double turns = xi[0] * s.position[0] + xi[1] * s.position[1] + xi[2] * s.position[2];
    sum += s.weight * layers[s.coset] * std::cos(2 * pi * turns);
  }
  return sum;
}

} // namespace bccsplat
