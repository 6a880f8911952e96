// SPDX-License-Identifier: Apache-2.0
// Cuts a slice, and reads from it or from the points it is made of.
#include "volume/open_slice.h"

#include <cmath>
#include <vector>

#include "motion/moving_series.h"
#include "slice/even_slice.h"
#include "volume/label_samples.h"
#include "volume/labels.h"
#include "volume/read_ranges.h"

namespace bccsplat {
namespace {

// Calls body(points, values) for each row of a grid.
template<class Body> void each_row(const Grid& grid, float* values, const Body& body) {
  const auto nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]);
  std::vector<Vec3> row(nx);
  for (size_t r = 0; r < ny * static_cast<size_t>(grid.dims[2]); ++r) {
    for (size_t x = 0; x < nx; ++x) {
      const Vec3 i{static_cast<double>(x), static_cast<double>(r % ny), static_cast<double>(r / ny)};
      for (size_t a = 0; a < 3; ++a) row[x][a] = grid.origin[a] + grid.step[a] * i[a];
    }
    body(std::span<const Vec3>(row), std::span(values + r * nx, nx));
  }
}

} // namespace

SliceRequest request_slice(const OpenVolume& volume, uint32_t channel, const char* kernel, uint32_t level,
                           const Hyperplane& plane, const HypersliceOptions& cut, bool keep) {
  (void)volume.lattice(level);                            // refuses what is beyond the last one
  if (level > 0 && is_labels(volume, channel)) level = 0; // of whose means the others are made
  const BrickBox region = cut.reads(volume.lattice(level), volume.kernel_of(kernel));
  return {channel, level, plane, cut, volume.coefficients(channel, kernel, level, region, keep)};
}

std::vector<CutPlan> plans_of(const OpenVolume& volume, const SliceRequest& made) {
  std::vector<CutPlan> plans{plan_cut(*made.coefficients, made.plane, made.cut)};
  if (made.cut.motion)
    for (const size_t f : volume.motion(*made.coefficients).frames_of(plans[0].position))
      plans.push_back(plan_moment(*made.coefficients, static_cast<double>(f), {0, 0}, {}));
  return plans;
}

OpenSlice cut_slice(const OpenVolume& volume, const SliceRequest& request, const Context& context) {
  const uint64_t read_before = volume.reader()->bytes_read();
  OpenSlice result;
  const SliceRequest made = as_cut(volume, request);
  result.channel = request.channel, result.level = request.level, result.cut = made.cut;
  const bool labels = cuts_labels(volume, request);
  const std::optional<IndexBox>& box = request.cut.box;
  const std::vector<CutPlan> plans = plans_of(volume, made);
  const CutPlan& plan = plans[0];
  FollowMoment follow;
  if (made.cut.motion)
    follow = [&](Slice& moment, const Context& with) {
      volume.motion(*made.coefficients).follow(moment, with);
    };
  result.slice = or_all_lacking(volume, request.level, plans, context,
                                [&] { return make_slice(plan, volume.affine(), context, follow); });
  result.extraction = std::static_pointer_cast<const Extraction>(result.slice.scattered);
  if (plan.empty) result.slice.scattered = nullptr;
  if (labels) add_labels(result, volume, context);
  if (labels && box) cut_to_box(result.slice, clip_to_samples(*box, volume.lattice(0)));
  result.cut = request.cut;
  result.cut.once = false; // a trail of it has many moments
  result.slice.bytes_read = volume.reader()->bytes_read() - read_before;
  result.memory = Reservation(context.memory, result.slice.bytes(), "slice");
  return result;
}

namespace {

// Replaces values that are there by labels.
void take_labels(const SliceLabels& labels, std::span<const Vec3> points, std::span<float> values,
                 std::span<std::array<float, 3>> gradients) {
  for (size_t n = 0; n < values.size(); ++n) {
    if (std::isnan(values[n])) continue;
    values[n] = labels.at(points[n]);
    if (!gradients.empty()) gradients[n] = {};
  }
}

} // namespace

void prefetch_slice(const OpenVolume& volume, const SliceRequest& request, const Context& context) {
  const SliceRequest made = as_cut(volume, request);
  const std::vector<CutPlan> plans = plans_of(volume, made);
  or_all_lacking(volume, request.level, plans, context, [&] {
    fetch(plans[0], context);
    if (made.cut.motion) volume.motion(*made.coefficients).prepare(plans[0].position, context);
  });
  if (!cuts_labels(volume, request)) return;
  const std::optional<IndexBox>& box = made.cut.box;
  hold_labels(volume, made.channel, -made.plane[4] / made.plane[3],
              box && made.cut.even ? index_box(*box, *made.cut.even) : box, context);
}

std::array<std::array<double, 2>, 3> OpenSlice::extent() const {
  std::array<std::array<double, 2>, 3> box;
  for (size_t a = 0; a < 3; ++a) {
    if (cut.box) {
      box[a] = {cut.box->begin[a], cut.box->end[a]};
      continue;
    }
    const double unit = slice.lattice_to_slice.linear[a][a], offset = slice.lattice_to_slice.offset[a];
    box[a] = {offset + unit * slice.domain_begin[a], offset + unit * slice.domain_end[a]};
  }
  return box;
}

Grid OpenSlice::own_grid() const {
  Grid grid;
  const auto box = extent();
  for (size_t a = 0; a < 3; ++a) {
    grid.origin[a] = box[a][0], grid.step[a] = 1;
    grid.dims[a] = static_cast<int32_t>(std::floor(box[a][1] - box[a][0] + 1e-6)) + 1;
  }
  return grid;
}

EvaluateMisses OpenSlice::evaluate(std::span<const Vec3> points, std::span<float> values,
                                   std::span<std::array<float, 3>> gradients, const Context& context) const {
  if (!extraction) {
    slice.coset.make(context);
    const EvaluateMisses misses = sample_points(slice, points, values, gradients, context);
    if (slice.labels) take_labels(*slice.labels, points, values, gradients);
    return misses;
  }
  EvaluateMisses misses;
  misses.outside = extraction->sample(points, values, gradients, context);
  misses.holes = hide_missing(slice, points, values);
  for (size_t n = 0; n < gradients.size(); ++n)
    if (std::isnan(values[n])) gradients[n].fill(values[n]);
  return misses;
}

void OpenSlice::sample(const Grid& grid, float* values, const Context& context) const {
  if (extraction)
    extraction->sample(grid, values, context);
  else
    slice.coset.make(context), sample_grid(slice, grid, values, context);
  if (extraction && slice.mask)
    each_row(grid, values, [&](auto points, auto row) { hide_missing(slice, points, row); });
  if (slice.labels)
    each_row(grid, values, [&](auto points, auto row) { take_labels(*slice.labels, points, row, {}); });
}

uint64_t OpenSlice::list(uint64_t capacity, float* uvw, float* coefficients, Progress& progress) const {
  return extraction ? extraction->list(capacity, uvw, coefficients, progress)
                    : list_points(slice, capacity, uvw, coefficients, progress);
}

} // namespace bccsplat
