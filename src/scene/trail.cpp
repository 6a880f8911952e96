// SPDX-License-Identifier: Apache-2.0
// Cuts the moments of a trail out of the 4D field: instants of a time slice, or parallel hyperplanes along
// the normal of another, each drawn as a still, or their mean or maximum over a sub-interval.
#include "scene/trail.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "scene/picture.h"
#include "scene/trail_layers.h"
#include "slice/hyperslice.h"
#include "volume/read_ranges.h"

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

// A moment of the trail, how it is cut, and so many frames later it is, where time is periodic, than the
// slice that is cut.
struct Still {
  CutPlan plan;
  Moment moment;
  double later = 0;
};

// Adds a moment that is a slice of its own; left to a GPU, which merges it of layers, it has no points.
void add_slice(Trail& trail, Slice&& slice, const Moment& m, bool left, const Context& context) {
  widen_bounds(trail, slice);
  trail.moments.push_back(
      {{{static_cast<uint32_t>(trail.sources.size()), 1.0f}}, slice.frame, m.weight, m.interval});
  if (left)
    trail.sources.push_back({std::move(slice), {}, {}});
  else
    add_source(trail, std::move(slice), context);
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

std::vector<Still> plan_times(const Coefficients& coefficients, const Slice& slice,
                              const TrailOptions& options, const HypersliceOptions& like) {
  const Lattice4& lattice = coefficients.source().lattice();
  const auto [from, to] =
      time_span(lattice, slice.frame + options.interval[0], slice.frame + options.interval[1]);
  std::vector<Still> stills;
  if (!(from < to) || lattice.is_static()) return stills;
  const double part = (to - from) / options.intervals;
  const int samples = options.samples > 0 ? options.samples
                                          : std::clamp(static_cast<int>(std::ceil(part / lattice.time_step)),
                                                       fewest_stills, most_stills);
  const bool classified = options.content == TrailContent::classified,
             largest = options.content == TrailContent::maximum;
  const double around = classified ? 0 : part / 2;
  HypersliceOptions cut = like;
  cut.thickness = {0, largest ? ThicknessKind::maximum : ThicknessKind::mean};
  cut.merge_later = leaves_moments(coefficients, options, like);
  for (const Moment& m : midpoints(from, to, shares_of(options), classified ? samples : 1)) {
    CutPlan plan = plan_moment(coefficients, m.at, {-around, around}, cut);
    if (largest) {
      plan.instants.clear();
      for (const Moment& still : midpoints(m.at - around, m.at + around, std::array{1.0}, samples))
        plan.instants.push_back(still.at);
      plan.position = plan.instants.front();
    }
    stills.push_back({std::move(plan), m});
  }
  return stills;
}

// Returns the frames of a turn of periodic time, which a time slice goes through; 0: there is none.
double turn_of(const Slice& slice, const Lattice4& lattice) {
  return lattice.periodic && slice.is_time_slice() ? lattice.last_frame() : 0;
}

// Returns the offsets along the normal between which the hyperplane meets the domain, or a turn before and
// behind it.
std::array<double, 2> offsets_inside(const Slice& slice, const Lattice4& lattice) {
  const Hyperplane& h = slice.hyperplane;
  double low = h[4], high = h[4];
  for (size_t a = 0; a < 4; ++a) {
    const double across = h[a] * lattice.domain_end(a);
    (across < 0 ? low : high) += across;
  }
  const double turn = turn_of(slice, lattice);
  return {low - turn, high + turn};
}

std::vector<Still> plan_planes(const Coefficients& coefficients, const Slice& slice,
                               const TrailOptions& options, const HypersliceOptions& like) {
  const Hyperplane h = slice.hyperplane;
  const Lattice4& lattice = coefficients.source().lattice();
  const auto inside = offsets_inside(slice, lattice);
  const double from = std::clamp(options.interval[0], inside[0], inside[1]);
  const double to = std::clamp(options.interval[1], inside[0], inside[1]);
  std::vector<Still> stills;
  if (!(from < to)) return stills;
  const double part = (to - from) / options.intervals;
  const auto cut = [&](double offset, const Thickness& thickness) {
    HypersliceOptions o = like;
    o.interval = {0, 0}, o.motion = false; // trails are means of the field
    o.thickness = thickness;
    if (o.axes)
      for (size_t i = 0; i < 4; ++i) o.axes->origin[i] += offset * h[i];
    return plan_cut(coefficients, h.moved(offset), o);
  };
  const bool classified = options.content == TrailContent::classified;
  const double units = part * std::max(1.0, lattice_density(lattice, h.normal()));
  const int samples = !classified ? 1
                      : options.samples > 0
                          ? options.samples
                          : std::clamp(static_cast<int>(std::ceil(units)), fewest_stills, most_stills);
  Thickness thickness = like.thickness;
  if (!classified)
    thickness = {part, options.content == TrailContent::mean ? ThicknessKind::mean : ThicknessKind::maximum};
  const double turn = turn_of(slice, lattice);
  for (const Moment& m : midpoints(from, to, shares_of(options), samples)) {
    const double at = turn > 0 ? h[3] * m.at - h[3] * h[4] : 0; // the frame
    const double later = at < 0 ? -turn : at > turn ? turn : 0;
    stills.push_back({cut(m.at - h[3] * later, thickness), m, later});
  }
  return stills;
}

bool is_in_time(const Slice& slice, const HypersliceOptions& like) {
  const bool own_lattice =
      like.spacing == 0 && !like.bandwidth && !like.target && !like.axes && like.thickness.length == 0;
  return slice.is_time_slice() && own_lattice;
}

std::vector<Still> plan_trail(const Coefficients& coefficients, const Slice& slice,
                              const TrailOptions& options, const HypersliceOptions& like) {
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
  return is_in_time(slice, like) ? plan_times(coefficients, slice, options, like)
                                 : plan_planes(coefficients, slice, options, like);
}

Trail make_stills(const std::vector<Still>& stills, const Coefficients& coefficients, const Slice& slice,
                  const TrailOptions& options, const HypersliceOptions& like, const Affine3& index_to_world,
                  const Context& context) {
  Trail trail;
  const bool in_time = is_in_time(slice, like), left = in_time && leaves_moments(coefficients, options, like);
  if (in_time && !left && options.content == TrailContent::classified && !like.even) {
    std::vector<Moment> moments;
    for (const Still& s : stills) moments.push_back(s.moment);
    if (add_layers(trail, coefficients, slice, moments, context)) return trail;
  }
  for (const Still& s : stills)
    if (Slice made = make_slice(s.plan, in_time ? slice.slice_to_world : index_to_world, context);
        !made.empty()) {
      made.origin[3] += s.later;
      add_slice(trail, std::move(made), s.moment, left, context);
    }
  if (!left || trail.moments.empty()) return trail;
  HypersliceOptions now = like;
  now.merge_later = false;
  trail.by_cpu = std::make_shared<const TrailByCpu>(
      [&coefficients, slice, options, now, index_to_world](const Context& with) {
        return make_trail(coefficients, slice, options, now, index_to_world, with);
      });
  return trail;
}

} // namespace

Trail make_trail(const Coefficients& coefficients, const Slice& slice, const TrailOptions& options,
                 const HypersliceOptions& like, const Affine3& index_to_world, const Context& context) {
  return make_stills(plan_trail(coefficients, slice, options, like), coefficients, slice, options, like,
                     index_to_world, context);
}

Trail make_trail(const OpenVolume& volume, const OpenSlice& slice, const TrailOptions& options,
                 const Context& context) {
  HypersliceOptions reads = slice.cut;
  if (options.content == TrailContent::maximum) reads.thickness = {1, ThicknessKind::maximum};
  const auto coefficients = volume.coefficients(slice.channel, slice.slice.kernel.name.c_str(), slice.level,
                                                reads.reads(volume.lattice(slice.level), slice.slice.kernel));
  const std::vector<Still> stills = plan_trail(*coefficients, slice.slice, options, slice.cut);
  std::vector<CutPlan> plans;
  for (const Still& s : stills) plans.push_back(s.plan);
  Trail trail = or_all_lacking(volume, slice.level, plans, context, [&] {
    return make_stills(stills, *coefficients, slice.slice, options, slice.cut, volume.affine(), context);
  });
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
