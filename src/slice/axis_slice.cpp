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
constexpr double read_end = 0.5;

// Returns how many planes on either side of a position matter, for kernel and prefilter.
int reach_planes(const Lattice4& lattice, const Kernel& kernel) {
  const double support = kernel.time.half_width / kernel_time_per_layer(lattice);
  const int prefilter = lattice.space.bcc ? prefilter_reach(kernel.prefilter4).time
                                          : prefilter_reach(make_cc_kernel(kernel.name).time).time;
  return static_cast<int>(std::ceil(support)) + prefilter + 1;
}

} // namespace

bool can_turn(const Coefficients& coefficients, size_t axis) {
  const SampleSource& source = coefficients.source();
  return axis < 3 && !source.lattice().is_static() && source.lattice().dims[axis] > 1;
}

Slice axis_slice(const Coefficients& coefficients, size_t axis, double position, const Thickness& thickness,
                 const Context& context) {
  const auto start = std::chrono::steady_clock::now();
  const Lattice4 turned = turned_lattice(coefficients.source().lattice(), axis);
  const double end = turned.last_frame(), half = thickness.length / 2;
  position = std::clamp(position, 0.0, end);
  const auto [low, high] = time_span(turned, position - half, position + half);
  // Mirror images beyond an end lie no further from it than what they are images of.
  const int reach = reach_planes(turned, coefficients.kernel());
  const auto plane = [&](double at) {
    return static_cast<int32_t>(std::floor(at / turned.time_step)) + turned.lead;
  };
  int32_t first = plane(low) - reach, last = plane(high) + 1 + reach;
  if (!turned.periodic) first = std::max(first, 0), last = std::min(last, turned.last_layer);
  Progress reading(context.progress, 0, read_end), cutting(context.progress, read_end, 1);
  const TurnedSamples samples(coefficients.samples(), coefficients.channel(), axis, first, last,
                              context.with(reading));
  const Coefficients planes(samples, 0, coefficients.kernel(), coefficients.prune(),
                            coefficients.cache_bytes());
  Slice slice = thick_time_slice(planes, position, {-half, half}, thickness.kind, {}, context.with(cutting));
  slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return slice;
}

} // namespace bccsplat
