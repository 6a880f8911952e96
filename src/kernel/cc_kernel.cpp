#include "kernel/cc_kernel.h"

#include <cmath>
#include <numbers>
#include <span>
#include <string_view>

#include "base/error.h"
#include "kernel/radial.h"

namespace bccsplat {
namespace {

constexpr double paper_gaussian = 2; // exp(-2 r^2)
constexpr double largest_radius = 2; // four sites per axis: what evaluation and splatting look at

TemporalKernel spline(int order) {
  TemporalKernel beta;
  beta.order = order;
  beta.half_width = order * std::numbers::sqrt2 / 2;
  return beta;
}

#include "kernel/cc_tables.inc"

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

double cc_lattice_sum(const Kernel& kernel, double x, double y, double z) {
  if (!kernel.normalised) return 1;
  // Poisson, axis by axis: 1 + 2 sum_n q^(n^2) cos(2 pi n x), q = exp(-pi^2 / g).
  const double q = std::exp(-std::numbers::pi * std::numbers::pi / paper_gaussian);
  const auto along = [&](double at) {
    const double turn = 2 * std::numbers::pi * at;
    return 1 + 2 * q * std::cos(turn) + 2 * q * q * q * q * std::cos(2 * turn);
  };
  return along(x) * along(y) * along(z);
}

} // namespace bccsplat
