// SPDX-License-Identifier: Apache-2.0
#include "slice/axis_slice.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"
#include "slice/time_slice.h"
#include "slice/turned_samples.h"

namespace bccsplat {
namespace {

// Reading the samples is about this share of a slice's work, for reports of progress.
constexpr double read_share = 0.5;

// Returns how many planes on either side of a position matter, for kernel and prefilter.
int reach_planes(const Lattice4& lattice, const Kernel& kernel) {
  const double support = kernel.time.half_width / kernel_time_per_layer(lattice);
  const int prefilter = lattice.space.bcc ? prefilter_reach(kernel.prefilter4).time
                                          : prefilter_reach(make_cc_kernel(kernel.name).time).time;
  return static_cast<int>(std::ceil(support)) + prefilter + 1;
}

// The planes across an axis that a slice is made of.
struct AxisPlanes {
  Lattice4 turned;
  double position;     // inside the domain
  int32_t first, last; // layers of the turned volume, along a periodic axis beyond its ends, too
};

AxisPlanes planes_of(const Coefficients& coefficients, size_t axis, double position,
                     const Thickness& thickness) {
  AxisPlanes p;
  p.turned = turned_lattice(coefficients.source().lattice(), axis);
  const double half = thickness.length / 2;
  p.position = std::clamp(position, 0.0, p.turned.last_frame());
  const auto [low, high] = time_span(p.turned, p.position - half, p.position + half);
  // Mirror images beyond an end lie no further from it than what they are images of.
  const int reach = reach_planes(p.turned, coefficients.kernel());
  const auto plane = [&](double at) {
    return static_cast<int32_t>(std::floor(at / p.turned.time_step)) + p.turned.lead;
  };
  p.first = plane(low) - reach, p.last = plane(high) + 1 + reach;
  if (!p.turned.periodic) p.first = std::max(p.first, 0), p.last = std::min(p.last, p.turned.last_layer);
  return p;
}

} // namespace

bool can_turn(const Coefficients& coefficients, size_t axis) {
  const SampleSource& source = coefficients.source();
  return axis < 3 && !source.lattice().is_static() && source.lattice().dims[axis] > 1;
}

Slice axis_slice(const Coefficients& coefficients, size_t axis, double position, const Thickness& thickness,
                 const Context& context) {
  const auto start = std::chrono::steady_clock::now();
  const AxisPlanes p = planes_of(coefficients, axis, position, thickness);
  const double half = thickness.length / 2;
  Progress reading(context.progress, 0, read_share), cutting(context.progress, read_share, 1);
  const TurnedSamples samples(coefficients.source(), coefficients.channel(), axis, p.first, p.last,
                              context.with(reading));
  const Coefficients planes(samples, 0, coefficients.kernel(), coefficients.prune(),
                            coefficients.cache_bytes());
  Slice slice =
      thick_time_slice(planes, p.position, {-half, half}, thickness.kind, {}, context.with(cutting));
  slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return slice;
}

void list_axis_reads(const Coefficients& coefficients, size_t axis, double position,
                     const Thickness& thickness, LayerReads& out) {
  const AxisPlanes p = planes_of(coefficients, axis, position, thickness);
  const SampleSource& samples = coefficients.source();
  const Lattice4& lattice = samples.lattice();
  samples.list_reads(all_layers(lattice), bricks_on(lattice.space, {axis, p.first, p.last}), out);
}

} // namespace bccsplat
