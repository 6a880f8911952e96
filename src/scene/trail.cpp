// SPDX-License-Identifier: Apache-2.0
// Cuts the moments of a trail out of the 4D field: instants of a time slice, or parallel hyperplanes along
// the normal of another, each drawn as a still, or their mean or maximum over a sub-interval.
#include "scene/trail.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "base/would_block.h"
#include "scene/picture.h"
#include "scene/trail_layers.h"
#include "slice/even_slice.h"
#include "slice/maximum_slice.h"
#include "slice/part.h"
#include "slice/time_slice.h"

namespace bccsplat {
namespace {

// Where the caller leaves the number of stills per sub-interval open it is one per layer, index unit, or
// lattice unit where that is less, within these limits. Few would show as separate pictures, many cost time
// (tests/bench/notes/trail.md). No measurement of the limits is noted.
constexpr int fewest_stills = 4, most_stills = 64;
// What a caller may ask for: more are taken for a mistake.
constexpr int most_samples = 4096, most_intervals = 256;

void widen_bounds(Trail& trail, const Slice& slice) {
  trail.bounds = trail.moments.empty() ? slice.bounds
                                       : std::array{std::min(trail.bounds[0], slice.bounds[0]),
                                                    std::max(trail.bounds[1], slice.bounds[1])};
}

// Adds a moment that is a slice of its own.
void add_slice(Trail& trail, Slice&& slice, const Moment& m, const Context& context) {
  widen_bounds(trail, slice);
  trail.moments.push_back(
      {{{static_cast<uint32_t>(trail.sources.size()), 1.0f}}, slice.frame, m.weight, m.interval});
  add_source(trail, std::move(slice), context);
}

// Adds an instant, or a mean around one, that a GPU merges of layers; it has no points.
void add_later(Trail& trail, const Coefficients& coefficients, const Slice& slice, const Moment& m,
               double around, const HypersliceOptions& like, const Context& context) {
  Slice made = thick_time_slice(coefficients, m.at, {-around, around}, ThicknessKind::mean,
                                slice.slice_to_world, context, true);
  if (like.box) cut_to_box(made, *like.box);
  widen_bounds(trail, made);
  trail.moments.push_back(
      {{{static_cast<uint32_t>(trail.sources.size()), 1.0f}}, made.frame, m.weight, m.interval});
  trail.sources.push_back({std::move(made), {}, {}});
}

// Returns whether the moments of a trail in time are left to a GPU.
bool leaves_moments(const Coefficients& coefficients, const TrailOptions& options,
                    const HypersliceOptions& like) {
  const Corrections* const fix = coefficients.corrections();
  return like.merge_later && !like.even && options.content != TrailContent::maximum && !(fix && fix->any()) &&
         !coefficients.masks();
}

// Returns the share of each sub-interval in the trail's extinction.
std::vector<double> shares_of(const TrailOptions& options) {
  const double count = options.intervals;
  if (options.weights.empty()) return std::vector<double>(static_cast<size_t>(options.intervals), 1 / count);
  const double sum = std::accumulate(options.weights.begin(), options.weights.end(), 0.0);
  std::vector<double> shares = options.weights;
  for (double& share : shares) share /= sum;
  return shares;
}

// Returns stills at the midpoints of `count` equal parts of the sub-intervals of [begin, end], without those
// that have no share.
std::vector<Moment> midpoints(double begin, double end, std::span<const double> shares, int count) {
  std::vector<Moment> moments;
  const double part = (end - begin) / static_cast<double>(shares.size());
  for (int i = 0; i < static_cast<int>(shares.size()); ++i)
    for (int k = 0; k < count; ++k)
      if (const double share = shares[static_cast<size_t>(i)]; share > 0)
        moments.push_back({begin + (i + (k + 0.5) / count) * part, share / count, i});
  return moments;
}

void add_times(Trail& trail, const Coefficients& coefficients, const Slice& slice,
               const TrailOptions& options, const HypersliceOptions& like, const Context& context) {
  const Lattice4& lattice = coefficients.source().lattice();
  const auto [from, to] =
      time_span(lattice, slice.frame + options.interval[0], slice.frame + options.interval[1]);
  if (!(from < to) || lattice.is_static()) return;
  const double part = (to - from) / options.intervals;
  const int samples = options.samples > 0 ? options.samples
                                          : std::clamp(static_cast<int>(std::ceil(part / lattice.time_step)),
                                                       fewest_stills, most_stills);
  const auto within = [&](Slice made) {
    if (like.box) cut_to_box(made, like.even ? index_box(*like.box, *like.even) : *like.box);
    return like.even ? even_slice(made, like.even, context) : made;
  };
  const auto instant = [&](double frame) {
    return time_slice(coefficients, frame, {0, 0}, slice.slice_to_world, context);
  };
  Attempts attempts; // a host hears at once of all that the moments lack
  if (leaves_moments(coefficients, options, like)) {
    const bool mean = options.content == TrailContent::mean;
    for (const Moment& m : midpoints(from, to, shares_of(options), mean ? 1 : samples))
      attempts.attempt([&] { add_later(trail, coefficients, slice, m, mean ? part / 2 : 0, like, context); });
    attempts.throw_if_waiting();
    return;
  }
  if (options.content == TrailContent::classified) {
    const auto moments = midpoints(from, to, shares_of(options), samples);
    if (!like.even && add_layers(trail, coefficients, slice, moments, context)) return;
    for (const Moment& m : moments)
      attempts.attempt([&] { add_slice(trail, within(instant(m.at)), m, context); });
    attempts.throw_if_waiting();
    return;
  }
  for (const Moment& m : midpoints(from, to, shares_of(options), 1)) {
    if (options.content == TrailContent::mean) {
      attempts.attempt([&] {
        const std::array<double, 2> around{-part / 2, part / 2};
        add_slice(trail, within(time_slice(coefficients, m.at, around, slice.slice_to_world, context)), m,
                  context);
      });
      continue;
    }
    SiteMaxima maxima;
    for (const Moment& still : midpoints(m.at - part / 2, m.at + part / 2, std::array{1.0}, samples))
      attempts.attempt([&] { maxima.add(instant(still.at), context); });
    if (!attempts.waits()) add_slice(trail, within(maxima.finish(context)), m, context);
  }
  attempts.throw_if_waiting();
}

// Returns the offsets along the normal between which the hyperplane meets the domain.
std::array<double, 2> offsets_inside(const Hyperplane& h, const Lattice4& lattice) {
  double low = h[4], high = h[4];
  for (size_t a = 0; a < 4; ++a) {
    const double across = h[a] * lattice.domain_end(a);
    (across < 0 ? low : high) += across;
  }
  return {low, high};
}

void add_planes(Trail& trail, const Coefficients& coefficients, const Slice& slice,
                const TrailOptions& options, const HypersliceOptions& like, const Affine3& index_to_world,
                const Context& context) {
  const Hyperplane h = slice.hyperplane;
  const auto inside = offsets_inside(h, coefficients.source().lattice());
  const double from = std::clamp(options.interval[0], inside[0], inside[1]);
  const double to = std::clamp(options.interval[1], inside[0], inside[1]);
  if (!(from < to)) return;
  const double part = (to - from) / options.intervals;
  const auto cut = [&](double offset, const Thickness& thickness) {
    HypersliceOptions o = like;
    o.interval = {0, 0};
    o.thickness = thickness;
    if (o.axes)
      for (size_t i = 0; i < 4; ++i) o.axes->origin[i] += offset * h[i];
    return hyperslice(coefficients, h.moved(offset), o, index_to_world, context);
  };
  const bool classified = options.content == TrailContent::classified;
  const double units = part * std::max(1.0, lattice_density(coefficients.source().lattice(), h.normal()));
  const int samples = !classified ? 1
                      : options.samples > 0
                          ? options.samples
                          : std::clamp(static_cast<int>(std::ceil(units)), fewest_stills, most_stills);
  Thickness thickness = like.thickness;
  if (!classified)
    thickness = {part, options.content == TrailContent::mean ? ThicknessKind::mean : ThicknessKind::maximum};
  Attempts attempts;
  for (const Moment& m : midpoints(from, to, shares_of(options), samples))
    attempts.attempt([&] {
      if (Slice s = cut(m.at, thickness); !s.empty()) add_slice(trail, std::move(s), m, context);
    });
  attempts.throw_if_waiting();
}

} // namespace

Trail make_trail(const Coefficients& coefficients, const Slice& slice, const TrailOptions& options,
                 const HypersliceOptions& like, const Affine3& index_to_world, const Context& context) {
  if (!(options.interval[0] <= options.interval[1]) || !std::isfinite(options.interval[0]) ||
      !std::isfinite(options.interval[1]))
    fail(Code::invalid_argument, "trail: the interval must be finite and ordered");
  if (options.samples < 0 || options.samples > most_samples || options.intervals < 1 ||
      options.intervals > most_intervals)
    fail(Code::invalid_argument, "trail: at most ", most_samples, " samples in each of 1 .. ", most_intervals,
         " sub-intervals");
  if (!options.weights.empty() && options.weights.size() != static_cast<size_t>(options.intervals))
    fail(Code::invalid_argument, "trail: ", options.weights.size(), " weights for ", options.intervals,
         " sub-intervals; give one for each");
  Trail trail;
  const bool own_lattice =
      like.spacing == 0 && !like.bandwidth && !like.target && !like.axes && like.thickness.length == 0;
  if (!slice.is_time_slice() || !own_lattice) {
    add_planes(trail, coefficients, slice, options, like, index_to_world, context);
    return trail;
  }
  add_times(trail, coefficients, slice, options, like, context);
  if (!leaves_moments(coefficients, options, like) || trail.moments.empty()) return trail;
  HypersliceOptions now = like;
  now.merge_later = false;
  trail.by_cpu = std::make_shared<const TrailByCpu>(
      [&coefficients, slice, options, now, index_to_world](const Context& with) {
        return make_trail(coefficients, slice, options, now, index_to_world, with);
      });
  return trail;
}

Trail make_trail(const OpenVolume& volume, const OpenSlice& slice, const TrailOptions& options,
                 const Context& context) {
  HypersliceOptions reads = slice.cut;
  if (options.content == TrailContent::maximum) reads.thickness = {1, ThicknessKind::maximum};
  const auto coefficients = volume.coefficients(slice.channel, slice.slice.kernel.name.c_str(), slice.level,
                                                reads.reads(volume.lattice(slice.level)));
  Trail trail = make_trail(*coefficients, slice.slice, options, slice.cut, volume.info().affine, context);
  if (trail.by_cpu) trail.coefficients = coefficients;
  return trail;
}

std::vector<TransferFunction> TrailLook::functions_with(const TransferFunction& of_slice) const {
  std::vector<TransferFunction> out = functions;
  if (out.empty()) out.push_back(of_slice);
  if (!colors.empty()) out.resize(colors.size(), out.front());
  for (size_t i = 0; i < colors.size(); ++i) out[i] = tinted(out[i], colors[i]);
  return out;
}

void show_trail(const Trail& trail, const TrailLook& look, Scene& scene) {
  scene.trail_functions = look.functions_with(scene.function);
  scene.trail = &trail;
  scene.combine = look.combine, scene.trail_unlit = look.unlit;
}

TransferFunction tinted(const TransferFunction& function, const Vec3& color) {
  TransferFunction f = function;
  for (ColorPoint& p : f.colors) p.color = color;
  return f;
}

Vec3 ramp_color(int interval, int intervals) {
  const double x = intervals > 1 ? 2.0 * interval / (intervals - 1) - 1 : 0; // -1 .. 1
  constexpr Vec3 cold{0.05, 0.2, 1}, middle{0.9, 0.9, 0.9}, warm{1, 0.3, 0.02};
  return x < 0 ? (1 + x) * middle + (-x) * cold : (1 - x) * middle + x * warm;
}

} // namespace bccsplat
