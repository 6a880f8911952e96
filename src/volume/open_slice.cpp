// SPDX-License-Identifier: Apache-2.0
// Cuts a hyperslice or extracts the paper's points, and reads from either.
#include "volume/open_slice.h"

#include <chrono>
#include <cmath>
#include <vector>

#include "slice/masked_slice.h"
#include "volume/labels.h"

namespace bccsplat {
namespace {

// Extracted points on a grid, row by row.
void sample_extracted(const OpenSlice& slice, const Grid& grid, float* values, const Context& context) {
  slice.extraction->sample(grid, values, context);
  if (!slice.slice.mask) return;
  const size_t nx = grid.dims[0], ny = grid.dims[1];
  std::vector<Vec3> row(nx);
  for (size_t r = 0; r < ny * grid.dims[2]; ++r) {
    for (size_t x = 0; x < nx; ++x) {
      const Vec3 i{static_cast<double>(x), static_cast<double>(r % ny), static_cast<double>(r / ny)};
      for (size_t a = 0; a < 3; ++a) row[x][a] = grid.origin[a] + grid.step[a] * i[a];
    }
    hide_missing(slice.slice, row, {values + r * nx, nx});
  }
}

// A slice of the paper's extracted points.
void extract(OpenSlice& result, const SliceRequest& request, const Affine3& affine, const Context& context) {
  const Coefficients& coefficients = *request.coefficients;
  const PlaneOptions plane = extraction_options(request.cut);
  const auto start = std::chrono::steady_clock::now();
  result.slice = bare_plane(coefficients, request.plane, plane, affine);
  mask_slice(result.slice, coefficients);
  result.slice.kernel = make_kernel("paper");
  result.extraction = std::make_shared<const Extraction>(
      coefficients.samples(), coefficients.channel(), request.plane,
      PlaneAxes{result.slice.origin, result.slice.basis}, result.slice.lattice_to_slice, context);
  if (!result.slice.empty()) result.slice.scattered = result.extraction;
  result.slice.bounds = result.extraction->bounds();
  result.slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

PlaneOptions extraction_options(const HypersliceOptions& o) {
  if (o.even) fail(Code::unsupported, "slice: extracted points stand in index space; make them with INDEX");
  if (o.thickness.length != 0 || o.has_interval() || o.spacing != 0 || o.bandwidth || o.target || o.box)
    fail(Code::unsupported,
         "slice: extracted points take no thickness, interval, spacing, bandwidth, lattice or box");
  PlaneOptions plane;
  plane.time_length = o.time_length;
  plane.axes = o.axes;
  return plane;
}

SliceRequest request_slice(const OpenVolume& volume, uint32_t channel, const char* kernel, uint32_t level,
                           const Hyperplane& plane, const HypersliceOptions& cut, bool extracted) {
  return {channel, level,     plane,
          cut,     extracted, volume.coefficients(channel, kernel, level, cut.reads(volume.lattice(level)))};
}

OpenSlice cut_slice(const OpenVolume& volume, const SliceRequest& request, const Context& context) {
  const uint64_t read_before = volume.reader()->bytes_read();
  OpenSlice result;
  result.channel = request.channel, result.level = request.level;
  const bool labels = cuts_labels(volume, request);
  result.cut = request.cut;
  const std::optional<IndexBox>& box = request.cut.box;
  for (size_t a = 0; labels && box && a < 3; ++a) // labels stand at samples, wherever a box ends
    result.cut.box->begin[a] = std::floor(box->begin[a]), result.cut.box->end[a] = std::ceil(box->end[a]);
  if (request.extracted)
    extract(result, request, volume.affine(), context);
  else
    result.slice =
        hyperslice(*request.coefficients, labels ? plane_of_samples(volume, request.plane) : request.plane,
                   result.cut, volume.affine(), context);
  if (labels) add_labels(result, volume, context);
  if (labels && box) cut_to_box(result.slice, clip_to_samples(*box, volume.lattice(0)));
  result.cut = request.cut;
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

void take_labels(const SliceLabels& labels, const Grid& grid, float* values) {
  const size_t nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]);
  std::vector<Vec3> row(nx);
  for (size_t r = 0; r < ny * static_cast<size_t>(grid.dims[2]); ++r) {
    for (size_t x = 0; x < nx; ++x) {
      const Vec3 i{static_cast<double>(x), static_cast<double>(r % ny), static_cast<double>(r / ny)};
      for (size_t a = 0; a < 3; ++a) row[x][a] = grid.origin[a] + grid.step[a] * i[a];
    }
    take_labels(labels, row, {values + r * nx, nx}, {});
  }
}

} // namespace

void prefetch_slice(const SliceRequest& request, const Context& context) {
  if (request.extracted) fail(Code::unsupported, "prefetch: extracted points read samples on their own");
  prepare_hyperslice(*request.coefficients, request.plane, request.cut, context);
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
    sample_extracted(*this, grid, values, context);
  else
    slice.coset.make(context), sample_grid(slice, grid, values, context);
  if (slice.labels) take_labels(*slice.labels, grid, values);
}

uint64_t OpenSlice::list(uint64_t capacity, float* uvw, float* coefficients, Progress& progress) const {
  return extraction ? extraction->list(capacity, uvw, coefficients, progress)
                    : list_points(slice, capacity, uvw, coefficients, progress);
}

} // namespace bccsplat
