// SPDX-License-Identifier: Apache-2.0
// Cuts a slice by the way of its plan, and mends it.
#include "slice/hyperslice.h"

#include "field/masks.h"
#include "slice/axis_slice.h"
#include "slice/corrected_slice.h"
#include "slice/even_slice.h"
#include "slice/extraction.h"
#include "slice/maximum_slice.h"
#include "slice/plane_slice.h"
#include "slice/time_slice.h"

namespace bccsplat {
namespace {

using Way = CutPlan::Way;

// Cutting is about this share of the work on a slice that is corrected afterwards, for reports of progress.
constexpr double mend_begin = 0.7;
constexpr double even_begin = 0.5; // the same of a slice that is resampled evenly

Slice largest_of_instants(const CutPlan& plan, const Affine3& index_to_world, const Context& context) {
  SiteMaxima maxima;
  const double part = 1 / static_cast<double>(plan.instants.size() + 1);
  double begin = 0;
  for (const double at : plan.instants) {
    Progress making(context.progress, begin, begin + part / 2),
        comparing(context.progress, begin + part / 2, begin + part);
    maxima.add(make_slice(plan.instant(at), index_to_world, context.with(making)), context.with(comparing));
    begin += part;
  }
  Progress filtering(context.progress, 1 - part, 1);
  return maxima.finish(context.with(filtering));
}

Slice cut(const CutPlan& plan, const Affine3& index_to_world, const Context& context) {
  const Coefficients& coefficients = *plan.coefficients;
  const Hyperplane& h = plan.hyperplane;
  if (plan.way == Way::time)
    return plan.instants.empty() ? merged_moment(plan, index_to_world, context)
                                 : largest_of_instants(plan, index_to_world, context);
  if (plan.way == Way::plane) return plane_slice(coefficients, h, plan.options, index_to_world, context);
  if (plan.way == Way::axis) {
    Slice slice = axis_slice(coefficients, plan.axis, plan.position, plan.options.thickness, context);
    slice.hyperplane = h;
    slice.origin = {};
    slice.origin[plan.axis] = plan.position;
    slice.basis = plane_axes(h).basis;
    slice.frame = 0;
    slice.slice_to_world =
        world_affine({slice.origin, slice.basis}, index_to_world, plan.options.time_length);
    return slice;
  }
  Slice slice = bare_plane(coefficients, h, plan.options, index_to_world);
  slice.kernel = make_kernel("paper");
  const auto points = std::make_shared<const Extraction>(coefficients.source(), coefficients.channel(), h,
                                                         PlaneAxes{slice.origin, slice.basis},
                                                         slice.lattice_to_slice, context);
  slice.bounds = points->bounds();
  slice.scattered = points;
  return slice;
}

void mask(Slice& slice, const CutPlan& plan) {
  const Masks* const masks = plan.coefficients->masks();
  if (!masks) return;
  const int64_t first = masks->counted_frame(plan.masks[0]), last = masks->counted_frame(plan.masks[1]);
  std::vector<FrameMaskPtr> frames;
  for (int64_t f = first; f <= last; ++f) frames.push_back(masks->frame(f));
  const SliceMask made(*masks, slice.origin, slice.basis, first, std::move(frames));
  if (!made.any()) return;
  const bool evenly = plan.way == Way::plane && plan.options.even;
  slice.mask =
      std::make_shared<const SliceMask>(evenly ? made.from_even(plan.options.even, slice.origin) : made);
  slice.holes_by_mask = !slice.has_holes;
  slice.has_holes = true;
}

} // namespace

Slice make_slice(const CutPlan& plan, const Affine3& index_to_world, const Context& context,
                 const FollowMoment& follow) {
  const HypersliceOptions& options = plan.options;
  const bool resampled = plan.way == Way::plane && options.even, // of the field with its corrections
      moment = plan.way == Way::time, evenly = options.even && !resampled;
  const bool compared = !moment && !resampled && plan.way != Way::points && plan.coefficients->corrections();
  const double even_at = evenly ? even_begin : 1,
               mend_at = compared || follow ? even_at * mend_begin : even_at;
  Progress cutting(context.progress, 0, mend_at), mending(context.progress, mend_at, even_at),
      sampling(context.progress, even_at, 1);
  Slice slice = cut(plan, index_to_world, context.with(cutting));
  if (plan.empty) return slice;
  if (follow) follow(slice, context.with(mending));
  if (plan.instants.empty()) { // which have masks and corrections
    mask(slice, plan);
    if (moment)
      correct_time_slice(slice, *plan.coefficients, plan.corrections, plan.corrected, options.thickness.kind);
    else if (compared)
      correct_slice(slice, *plan.coefficients, options.thickness, context.with(mending));
  }
  if (options.box) cut_to_box(slice, options.even ? index_box(*options.box, *options.even) : *options.box);
  return evenly ? even_slice(slice, options.even, context.with(sampling)) : slice;
}

} // namespace bccsplat
