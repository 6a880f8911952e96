// SPDX-License-Identifier: Apache-2.0
// Chooses how a hyperplane is cut, checks that the options allow it, and tells what that takes.
#include "slice/cut_plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "field/corrections.h"
#include "field/evaluate.h"
#include "field/footprint/patch.h"
#include "kernel/cc_kernel.h"
#include "slice/axis_slice.h"
#include "slice/even_slice.h"
#include "slice/extraction.h"
#include "slice/plane_slice.h"

namespace bccsplat {
namespace {

using Way = CutPlan::Way;

constexpr double touch_tolerance = 1e-9; // index units: a hyperplane this far beyond an end still touches it

void check_options(const HypersliceOptions& o, bool time_slice, const Lattice4& lattice,
                   const std::string& kernel) {
  if (!(o.thickness.length >= 0 && std::isfinite(o.thickness.length)))
    fail(Code::invalid_argument, "slice: the thickness must be 0 or positive");
  if (!(o.spacing >= 0 && std::isfinite(o.spacing)))
    fail(Code::invalid_argument, "slice: the spacing must be 0 or positive");
  if (o.bandwidth && (o.method == SliceMethod::merged || kernel != "paper" || o.thickness.length > 0 ||
                      o.has_interval() || o.even))
    fail(Code::unsupported, "slice: bandwidths are of equation (6): of resampled slices under the kernel "
                            "\"paper\", without thickness and interval");
  if (o.bandwidth && lattice.is_static())
    fail(Code::unsupported, "slice: a static volume has no bandwidth along time");
  if (o.has_interval() && !time_slice)
    fail(Code::unsupported, "slice: an interval belongs to time slices (a = b = c = 0) only");
  if (o.has_interval() && o.thickness.length > 0)
    fail(Code::invalid_argument, "slice: interval and thickness exclude each other");
  if (lattice.is_static() && o.thickness.length > 0)
    fail(Code::unsupported, "slice: a static volume has no thickness in time");
}

// Sets the way of a merged slice, and where it lies; of others it stays.
void choose_way(CutPlan& plan) {
  const Coefficients& coefficients = *plan.coefficients;
  const Hyperplane& h = plan.hyperplane;
  const HypersliceOptions& options = plan.options;
  const Lattice4& lattice = coefficients.source().lattice();
  const auto cut = axis_cut(h, lattice.dims);
  const bool is_time = cut && cut->axis == 3;
  check_options(options, is_time, lattice, coefficients.kernel().name);
  const double end = cut ? lattice.domain_end(cut->axis) : 0;
  const bool inside = cut && cut->position >= -touch_tolerance && cut->position <= end + touch_tolerance;
  if (is_time && !inside && !lattice.is_static())
    fail(Code::out_of_domain, "slice: frame ", cut->position, " is outside the series, 0 to ", end);
  const bool own_density = options.spacing == 0 || (is_time && options.spacing == 1);
  const bool own_lattice = own_density && !options.axes && !options.bandwidth &&
                           (!options.target || (*options.target == LatticeKind::cc) != lattice.space.bcc);
  const bool can_merge = own_lattice && cut && (is_time || can_turn(coefficients, cut->axis));
  const bool misses = cut && !is_time && !inside; // an empty slice, whatever the method
  if (cut && !is_time && options.even && options.even->uneven(cut->axis) && options.thickness.length > 0)
    fail(Code::unsupported, "slice: axis ", "xyz"[cut->axis],
         " is unevenly spaced: in even positions a slice across it has no thickness");
  const bool merged = can_merge && !misses && options.method != SliceMethod::resampled;
  if (options.method == SliceMethod::merged && !can_merge && !misses)
    fail(Code::unsupported,
         "slice: merged slices are those at t, x, y or z = constant, on the volume's lattice, "
         "of files that store samples");
  if (options.box && !(is_time && merged))
    fail(Code::unsupported, "slice: a box belongs to merged time slices");
  if (options.motion &&
      !(is_time && merged && !options.box && options.thickness.length == 0 && !options.has_interval()))
    fail(Code::unsupported,
         "slice: what follows the motion is a merged time slice, an instant and all of it");
  if (options.has_interval() && (!can_merge || options.method == SliceMethod::resampled))
    fail(Code::unsupported, "slice: with an interval the slice is merged; use a thickness");
  if (!merged) return;
  plan.way = is_time ? Way::time : Way::axis, plan.axis = cut->axis, plan.position = cut->position;
  if (is_time && !lattice.is_static()) plan.position = std::clamp(cut->position, 0.0, end);
  if (!is_time && options.even) plan.position = options.even->index_of(cut->axis, cut->position);
}

// The frames around a time slice that it holds.
std::array<double, 2> interval_of(const HypersliceOptions& options) {
  const double half = options.thickness.length / 2;
  return options.has_interval() ? options.interval : std::array{-half, half};
}

// Returns the interval around the frame, clipped to the series.
std::array<double, 2> clipped_interval(const Lattice4& lattice, double frame,
                                       const std::array<double, 2>& interval) {
  if (!lattice.is_static() && time_span(lattice, frame, frame) != std::array{frame, frame})
    fail(Code::out_of_domain, "slice: frame ", frame, " is outside the series, 0 to ", lattice.last_frame());
  if (!(interval[0] <= interval[1]))
    fail(Code::invalid_argument, "slice: the interval ", interval[0], " .. ", interval[1], " is not ordered");
  if (interval[0] == interval[1]) return {frame, frame};
  return time_span(lattice, frame + interval[0], frame + interval[1]);
}

// The first and the last moment (frames) at which points of a slice's box stand.
std::array<double, 2> moments_of(const Slice& slice) {
  double low = 0, high = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (size_t a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? slice.domain_end[a] : slice.domain_begin[a];
    const Vec3 uvw = slice.lattice_to_slice.point(p);
    double t = slice.origin[3];
    for (size_t k = 0; k < 3; ++k) t += slice.basis[k][3] * uvw[k];
    low = corner == 0 ? t : std::min(low, t), high = corner == 0 ? t : std::max(high, t);
  }
  return {low, high};
}

// Points are extracted of a plane of the lattice's own spacing.
void check_extraction(const HypersliceOptions& o) {
  if (o.even) fail(Code::unsupported, "slice: extracted points stand in index space; make them with INDEX");
  if (o.thickness.length != 0 || o.has_interval() || o.spacing != 0 || o.bandwidth || o.target || o.box)
    fail(Code::unsupported,
         "slice: extracted points take no thickness, interval, spacing, bandwidth, lattice or box");
}

// Whether the field at the instant of a layer follows from that layer alone, in less time than from those
// around it.
bool has_stills(const Coefficients& coefficients) {
  const SampleSource& source = coefficients.source();
  const Lattice4& lattice = source.lattice();
  return !lattice.space.bcc && !lattice.is_static() && interpolates_on_cc(coefficients.kernel()) &&
         source.adds_layers(coefficients.channel());
}

// The layers that an instant is merged of.
void place_at_instant(CutPlan& plan, double frame) {
  const Coefficients& coefficients = *plan.coefficients;
  const Lattice4& lattice = coefficients.source().lattice();
  const auto own = has_stills(coefficients) ? layer_at(lattice, frame) : std::nullopt;
  plan.still = own.has_value();
  plan.layers =
      own ? std::vector<LayerWeight>{{*own, 1}} : instant_weights(lattice, coefficients.kernel(), frame);
}

// Sites that a kernel of the first coarser slice, for pictures, and its low-pass look at beyond a box.
constexpr int coarser_sites = 8;

// A length in lattice units, as sites of a coset.
int sites_of(const Lattice4& lattice, double length) {
  return static_cast<int>(std::ceil(length / coset_pitch(lattice.space)));
}

// How many sites further the coefficients of a slice look that are made of what it is at its sites.
int filtered_sites(const Lattice4& lattice, const Kernel& kernel) {
  if (!lattice.space.bcc) return prefilter_reach(make_cc_kernel(kernel.name).kernel.prefilter3).space;
  return (prefilter_reach(kernel.prefilter3).space + 1) / 2; // of planes
}

// Returns the samples whose corrections reach into a box. On a periodic axis the last one is the first, too.
Corrections::Box corrected_in(const IndexBox& box, const Lattice4& lattice) {
  constexpr double beyond = 1; // samples on either side that values at points around a face are made of
  Corrections::Box samples;
  for (size_t a = 0; a < 3; ++a) {
    if (lattice.turns(a)) continue;
    const double last = lattice.domain_end(a);
    samples.begin[a] = static_cast<int32_t>(std::clamp(std::floor(box.begin[a]) - beyond, 0.0, last));
    samples.end[a] = static_cast<int32_t>(std::clamp(std::ceil(box.end[a]) + beyond, 0.0, last)) + 1;
  }
  return samples;
}

void place_in_time(CutPlan& plan, const std::array<double, 2>& interval) {
  const Lattice4& lattice = plan.coefficients->source().lattice();
  const auto [t0, t1] = plan.frames = clipped_interval(lattice, plan.position, interval);
  const bool instant = !(t1 > t0), each = plan.options.thickness.kind == ThicknessKind::maximum;
  plan.way = Way::time;
  if (instant)
    place_at_instant(plan, t0);
  else
    plan.layers = mean_weights(lattice, plan.coefficients->kernel(), t0, t1);
  if (!lattice.is_static()) plan.corrections = plan.frames;
  // A slice of even positions is made of what stands around its box as well, and so are instants of an
  // interval.
  if (plan.options.box && !plan.options.even && (instant || !each))
    plan.corrected = corrected_in(*plan.options.box, lattice);
  // Each instant has a mask of its own; else it is that of the frame nearest to the slice's.
  plan.masks = instant || each ? plan.frames : std::array{plan.position, plan.position};
  if (instant || !each) return;
  for (const double node : gauss_legendre(thickness_nodes(t1 - t0, 1 / lattice.nominal_scales()[3])).node)
    plan.instants.push_back(t0 + (t1 - t0) * node);
}

} // namespace

BrickBox HypersliceOptions::reads(const Lattice4& lattice, const Kernel& kernel) const {
  if (!box) return {};
  const int field = sites_in_reach(lattice, kernel);
  int sites = std::max(coarser_sites, field);
  if (even) sites = std::max(sites, field + sites_of(lattice, looked_beyond));
  if (thickness.length > 0 && thickness.kind == ThicknessKind::maximum) // filtered of the field at its sites
    sites += field + filtered_sites(lattice, kernel);
  return bricks_around(even ? index_box(*box, *even) : *box, lattice, sites);
}

CutPlan CutPlan::instant(double frame) const {
  CutPlan one = *this;
  one.frames = one.masks = one.corrections = {frame, frame};
  place_at_instant(one, frame);
  one.instants.clear();
  one.options.box.reset(), one.options.even = nullptr, one.options.merge_later = one.options.once = false;
  one.corrected = {};
  return one;
}

CutPlan plan_moment(const Coefficients& coefficients, double frame, const std::array<double, 2>& interval,
                    const HypersliceOptions& options) {
  CutPlan plan{&coefficients, Hyperplane(0, 0, 0, 1, -frame), options};
  plan.position = frame;
  place_in_time(plan, interval);
  return plan;
}

CutPlan plan_cut(const Coefficients& coefficients, const Hyperplane& h, const HypersliceOptions& options) {
  CutPlan plan{&coefficients, h, options};
  if (options.method == SliceMethod::extracted)
    check_extraction(options), plan.way = Way::points;
  else
    choose_way(plan);
  const double end = coefficients.source().lattice().domain_end(3);
  if (plan.way == Way::time) {
    place_in_time(plan, interval_of(options));
  } else if (plan.way == Way::axis) {
    plan.masks = plan.corrections = {0, end};
  } else {
    const Slice bare = bare_plane(coefficients, h, options, {});
    plan.empty = bare.empty();
    if (!plan.empty) plan.masks = moments_of(bare);
    const double beyond = options.thickness.length / 2 * std::fabs(h[3]);
    plan.corrections = {std::clamp(plan.masks[0] - beyond, 0.0, end),
                        std::clamp(plan.masks[1] + beyond, 0.0, end)};
    if (plan.way == Way::points) plan.corrections = {0, -1}; // none
  }
  return plan;
}

std::vector<CoefficientLayer> layers_of(const CutPlan& plan, const Context& context) {
  return plan.coefficients->compact_layers(layers_of(plan.layers), context, plan.still);
}

void fetch(const CutPlan& plan, const Context& context) {
  if (plan.way != Way::time)
    fail(Code::unsupported, "prefetch: what merged time slices need is kept, and nothing of others");
  (void)layers_of(plan, context);
}

void list_layers(const CutPlan& plan, bool missing, LayerReads& out) {
  const Coefficients& coefficients = *plan.coefficients;
  const Lattice4& lattice = coefficients.source().lattice();
  if (plan.way == Way::time) return coefficients.list_reads(layers_of(plan.layers), missing, out, plan.still);
  if (plan.way == Way::points) return Extraction::list_reads(coefficients.source(), plan.hyperplane, out);
  if (plan.empty) return;
  if (plan.way == Way::axis)
    list_axis_reads(coefficients, plan.axis, plan.position, plan.options.thickness, out);
  else
    list_plane_reads(coefficients, plan.hyperplane, plan.options, out);
  if (!coefficients.corrections()) return; // else it is compared with the volume's field
  const auto [first, last] =
      layers_of_moments(lattice, coefficients.kernel(), plan.corrections[0], plan.corrections[1]);
  std::vector<int32_t> field(static_cast<size_t>(last - first + 1));
  std::iota(field.begin(), field.end(), first);
  coefficients.list_reads(field, missing, out);
}

} // namespace bccsplat
