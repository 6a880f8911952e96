// SPDX-License-Identifier: Apache-2.0
// Chooses how a hyperplane is cut, checks that the options allow it, and adds corrections and masks.
#include "slice/hyperslice.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "field/evaluate.h"
#include "slice/axis_slice.h"
#include "slice/corrected_slice.h"
#include "slice/even_slice.h"
#include "slice/masked_slice.h"
#include "slice/plane_slice.h"
#include "slice/time_slice.h"

namespace bccsplat {
namespace {

// Cutting is about this share of the work on a slice that is corrected afterwards, for reports of progress.
constexpr double mend_begin = 0.7;
constexpr double even_begin = 0.5;       // the same of a slice that is resampled evenly
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

// How a slice is made, checked.
struct Way {
  enum class Kind : uint8_t { time, axis, plane };
  Kind kind = Kind::plane;
  size_t axis = 0;     // of the first two
  double position = 0; // along it
};

Way choose_way(const Coefficients& coefficients, const Hyperplane& h, const HypersliceOptions& options) {
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
  if (options.has_interval() && (!can_merge || options.method == SliceMethod::resampled))
    fail(Code::unsupported, "slice: with an interval the slice is merged; use a thickness");
  if (!merged) return {};
  if (!is_time) {
    const double at = options.even ? options.even->index_of(cut->axis, cut->position) : cut->position;
    return {Way::Kind::axis, cut->axis, at};
  }
  return {Way::Kind::time, 3, lattice.is_static() ? cut->position : std::clamp(cut->position, 0.0, end)};
}

// The frames around a time slice that it holds.
std::array<double, 2> interval_of(const HypersliceOptions& options) {
  const double half = options.thickness.length / 2;
  return options.has_interval() ? options.interval : std::array{-half, half};
}

PlaneOptions plane_options(const HypersliceOptions& options) {
  PlaneOptions plane;
  plane.spacing = options.spacing;
  plane.time_length = options.time_length;
  plane.target = options.target.value_or(LatticeKind::bcc);
  plane.thickness = options.thickness;
  plane.axes = options.axes;
  plane.bandwidth = options.bandwidth;
  plane.even = options.even;
  return plane;
}

// Asks for what values of the volume's field at some moments are made of, as mending a slice does.
void rehearse_values(const Coefficients& coefficients, const std::array<double, 2>& moments,
                     const Context& context) {
  const auto [first, last] =
      layers_of_moments(coefficients.source().lattice(), coefficients.kernel(), moments[0], moments[1]);
  for (int32_t m = first; m <= last; ++m) (void)coefficients.compact_layers(std::span(&m, 1), context);
}

} // namespace

BrickBox HypersliceOptions::reads(const Lattice4& lattice) const {
  if (!box) return {};
  const bool filtered = thickness.length > 0 && thickness.kind == ThicknessKind::maximum;
  return bricks_around(even ? index_box(*box, *even) : *box, lattice,
                       filtered ? BeyondBox::prefilter : BeyondBox::field);
}

void prepare_hyperslice(const Coefficients& coefficients, const Hyperplane& h,
                        const HypersliceOptions& options, const Context& context) {
  const Way way = choose_way(coefficients, h, options);
  if (way.kind != Way::Kind::time)
    fail(Code::unsupported, "prefetch: what merged time slices need is kept, and nothing of others");
  prepare_time_slice(coefficients, way.position, interval_of(options), context);
}

namespace {

// A slice across an axis that the lattice's planes or layers are merged to.
Slice merged_slice_of(const Coefficients& coefficients, const Hyperplane& h, const Way& way,
                      const HypersliceOptions& options, const Affine3& index_to_world,
                      const Context& context) {
  if (way.kind == Way::Kind::time) {
    Slice slice = thick_time_slice(coefficients, way.position, interval_of(options), options.thickness.kind,
                                   index_to_world, context, options.merge_later && !options.even);
    if (options.box) cut_to_box(slice, options.even ? index_box(*options.box, *options.even) : *options.box);
    return slice;
  }
  const double cut_end = coefficients.corrections() ? mend_begin : 1;
  Progress cutting(context.progress, 0, cut_end), mending(context.progress, cut_end, 1);
  Slice slice = axis_slice(coefficients, way.axis, way.position, options.thickness, context.with(cutting));
  slice.hyperplane = h;
  slice.origin = {};
  slice.origin[way.axis] = way.position;
  slice.basis = plane_axes(h).basis;
  slice.frame = 0;
  slice.slice_to_world = world_affine({slice.origin, slice.basis}, index_to_world, options.time_length);
  mask_slice(slice, coefficients);
  correct_slice(slice, coefficients, options.thickness, context.with(mending));
  return slice;
}

} // namespace

Slice hyperslice(const Coefficients& coefficients, const Hyperplane& h, const HypersliceOptions& options,
                 const Affine3& index_to_world, const Context& context) {
  const Way way = choose_way(coefficients, h, options);
  if (way.kind != Way::Kind::plane) {
    if (!options.even) return merged_slice_of(coefficients, h, way, options, index_to_world, context);
    Progress cutting(context.progress, 0, even_begin), sampling(context.progress, even_begin, 1);
    const Slice slice = merged_slice_of(coefficients, h, way, options, index_to_world, context.with(cutting));
    return even_slice(slice, options.even, context.with(sampling));
  }
  const double cut_end = coefficients.corrections() && !options.even ? mend_begin : 1;
  Progress cutting(context.progress, 0, cut_end), mending(context.progress, cut_end, 1);
  Slice slice = plane_slice(coefficients, h, plane_options(options), index_to_world, context.with(cutting));
  if (options.even) {
    mask_slice(slice, coefficients);
    if (slice.mask)
      slice.mask = std::make_shared<const SliceMask>(slice.mask->from_even(options.even, slice.origin));
    return slice; // its points are of the field with its corrections
  }
  mask_slice(slice, coefficients);
  correct_slice(slice, coefficients, options.thickness, context.with(mending));
  return slice;
}

std::optional<SliceMoments> rehearse_hyperslice(const Coefficients& coefficients, const Hyperplane& h,
                                                const HypersliceOptions& options, const Context& context) {
  const Way way = choose_way(coefficients, h, options);
  const Lattice4& lattice = coefficients.source().lattice();
  const double end = lattice.domain_end(3);
  if (way.kind == Way::Kind::time) {
    const std::array<double, 2> around = interval_of(options);
    prepare_time_slice(coefficients, way.position, around, context);
    if (lattice.is_static()) return SliceMoments{};
    const auto span = time_span(lattice, way.position + around[0], way.position + around[1]);
    const bool each = options.thickness.kind == ThicknessKind::maximum; // instant of it has a mask
    return SliceMoments{each ? span : std::array{way.position, way.position}, span};
  }
  SliceMoments moments{{0, end}, {0, end}};
  if (way.kind == Way::Kind::axis) {
    rehearse_axis_slice(coefficients, way.axis, way.position, options.thickness, context);
  } else {
    const PlaneOptions plane = plane_options(options);
    const Slice slice = bare_plane(coefficients, h, plane, {});
    if (slice.empty()) return std::nullopt;
    rehearse_plane_slice(coefficients, h, plane, context);
    moments.masks = moments_of(slice);
    const double beyond = options.thickness.length / 2 * std::fabs(h[3]);
    moments.corrections = {std::clamp(moments.masks[0] - beyond, 0.0, end),
                           std::clamp(moments.masks[1] + beyond, 0.0, end)};
  }
  if (coefficients.corrections()) rehearse_values(coefficients, moments.corrections, context);
  return moments;
}

} // namespace bccsplat
