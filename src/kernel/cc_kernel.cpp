// SPDX-License-Identifier: Apache-2.0
// Makes the Cartesian forms of kernels: scaled for CC, with prefilters of cc_tables.inc, or for `exact` with
// the inverse of what the kernel makes of coefficients at the sites.
#include "kernel/cc_kernel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>

#include "base/error.h"
#include "kernel/radial.h"
#include "lattice/lattice.h"

namespace bccsplat {
namespace {

constexpr double paper_gaussian = 2; // exp(-2 r^2)
constexpr double largest_radius = 2; // four sites per axis: what evaluation and splatting look at

// The shape of kernel exact, a_2 .. a_7: of the shapes whose values at neighbours fall by one factor
// (cc_kernel.h) it is the most accurate one, interpolating, for waves up to 0.7 of the Nyquist frequency in
// space (tests/bench/notes/kernels.md).
constexpr double exact_radius = 2;
constexpr double exact_shape[] = {0.581315722, -3.87203097, 11.9788735, -18.2456612, 13.7852683, -4.0108329};
// The pole of the quadratic B-spline is -0.17, and its power of twice this 7e-7.
constexpr int exact_strides = 4;

TemporalKernel spline(int order) {
  TemporalKernel beta;
  beta.order = order;
  beta.half_width = order * std::numbers::sqrt2 / 2;
  return beta;
}

#include "kernel/cc_tables.inc"

// The pole inside the unit circle of the inverse of (side, centre, side), and its gain without the pole's.
struct Inverse {
  double pole, gain;
  Inverse(double centre, double side) {
    const double b = side / centre;
    pole = (std::sqrt(1 - 4 * b * b) - 1) / (2 * b);
    gain = (1 + pole * pole) / centre;
  }
  // Returns the sum of |taps|.
  [[nodiscard]] double sum() const { return gain / ((1 + pole) * (1 + pole)); }
};

// Makes the stages that invert what the kernel makes of coefficients at the sites.
void make_exact(CcKernel& cc) {
  Kernel& k = cc.kernel;
  k.normalised = false;
  k.space.radius = exact_radius;
  std::copy(std::begin(exact_shape), std::end(exact_shape), k.space.a.begin() + 2);
  const double integral = radial_integral(k.space);
  for (double& a : k.space.a) a /= integral;
  k.time = spline(3);
  // Each axis takes the cube root of the weight of the site itself.
  const double along = std::cbrt(k.space.value(0));
  const Inverse space(along, along * k.space.value(1) / k.space.value(0));
  k.prefilter3 = {{.self = space.gain * space.gain * space.gain, .pole = space.pole}};
  k.prefilter4 = k.prefilter3;
  const Inverse time(k.time.value(0), k.time.value(std::numbers::sqrt2));
  for (int stride = 1; stride <= exact_strides; stride *= 2) {
    const double q = std::pow(time.pole, stride), gain = stride == 1 ? time.gain : 1;
    cc.time.push_back({.self = gain * (1 + q * q), .temporal = gain * q, .stride = stride});
  }
  k.prefilter_gain = space.sum() * space.sum() * space.sum() * time.sum();
}

} // namespace

CcKernel make_cc_kernel(std::string_view name) {
  CcKernel cc{make_kernel(name), {}};
  Kernel& k = cc.kernel;
  k.prefilter3.clear(), k.prefilter4.clear();
  k.prefilter_gain = 1;
  if (k.space.radius > largest_radius)
    fail(
        Code::unsupported, "kernel ", k.name, " reaches ", k.space.radius,
        " T: on a Cartesian lattice take one that reaches no further than 2 T, such as radial20+b3 or paper");
  if (k.name == "exact") {
    make_exact(cc);
    return cc;
  }
  const double integral = radial_integral(k.space);
  for (double& a : k.space.a) a /= integral;
  if (k.normalised) {
    k.time = spline(2);
    return cc;
  }
  for (const CcSpace& space : cc_space)
    if (k.name.starts_with(space.name)) {
      k.prefilter3.assign(space.stages.begin(), space.stages.end());
      k.prefilter4 = k.prefilter3;
      k.prefilter_gain = space.gain;
    }
  k.time.bend = {}; // the stages in time are those of the B-splines
  for (const CcTime& time : cc_time)
    if (k.time.order == time.order) {
      cc.time.assign(time.stages.begin(), time.stages.end());
      k.prefilter_gain *= time.gain;
    }
  return cc;
}

bool goes_through_samples(const Lattice4& lattice, const Kernel& kernel) {
  if (lattice.kind != LatticeKind::cc || !interpolates_on_cc(kernel)) return false;
  const Vec4 step{lattice.space_step[0], lattice.space_step[1], lattice.space_step[2], lattice.time_step};
  for (size_t a = 0; a < 4; ++a)
    if (lattice.dims[a] > 1 && step[a] != 1) return false;
  return true;
}

double cc_first_wave() { return std::exp(-std::numbers::pi * std::numbers::pi / paper_gaussian); }

double cc_lattice_sum(const Kernel& kernel, double x, double y, double z) {
  if (!kernel.normalised) return 1;
  // By Poisson's formula the sum along each axis is 1 + 2 sum_n q^(n^2) cos(2 pi n x), q = exp(-pi^2 / g).
  const double q = cc_first_wave();
  const auto along = [&](double at) {
    const double turn = 2 * std::numbers::pi * at;
    return 1 + 2 * q * std::cos(turn) + 2 * q * q * q * q * std::cos(2 * turn);
  };
  return along(x) * along(y) * along(z);
}

} // namespace bccsplat
