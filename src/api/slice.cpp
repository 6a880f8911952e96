// SPDX-License-Identifier: Apache-2.0
// The slice functions of the C API: check, call hyperslice or the extraction, and read from what they made.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/slice_options.h"
#include "api/structs.h"
#include "field/sample_grid.h"
#include "slice/hyperslice.h"
#include "slice/masked_slice.h"
#include "slice/plane_slice.h"

using namespace bccsplat;
using namespace bccsplat::api;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(std::array<float, 3>) == 3 * sizeof(float));

namespace {

// A slice of the paper's extracted points.
void extract(bccsplat_slice& result, const Coefficients& coefficients, const Hyperplane& h,
             const HypersliceOptions& o, const Affine3& affine, const Context& context) {
  const PlaneOptions plane = extraction_options(o);
  const auto start = std::chrono::steady_clock::now();
  result.slice = bare_plane(coefficients, h, plane, affine);
  mask_slice(result.slice, coefficients);
  result.extraction =
      std::make_unique<const Extraction>(coefficients.samples(), coefficients.channel(), h,
                                         PlaneAxes{result.slice.origin, result.slice.basis}, context);
  result.slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Extracted points on a grid, row by row.
void sample_extracted(const bccsplat_slice& slice, const Grid& grid, float* values, const Context& context) {
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

// Slice-space extent: bounding box of the domain; a box that was asked for as it was asked for.
std::array<std::array<double, 2>, 3> extent_of(const bccsplat_slice& slice) {
  const Slice& s = slice.slice;
  std::array<std::array<double, 2>, 3> extent;
  for (size_t a = 0; a < 3; ++a) {
    if (slice.cut.box) {
      extent[a] = {slice.cut.box->begin[a], slice.cut.box->end[a]};
      continue;
    }
    const double unit = s.lattice_to_slice.linear[a][a], offset = s.lattice_to_slice.offset[a];
    extent[a] = {offset + unit * s.domain_begin[a], offset + unit * s.domain_end[a]};
  }
  return extent;
}

} // namespace

extern "C" {

bccsplat_status bccsplat_slice_create(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane,
                                      const bccsplat_slice_options* options, bccsplat_slice** slice) {
  return guard([&] {
    require(slice, "slice");
    *slice = nullptr;
    require(volume, "volume");
    const auto o = read_struct(options, "bccsplat_slice_options");
    const VolumeInfo& info = volume->info();
    HypersliceOptions cut = read_slice_options(o, info);
    const Hyperplane h = read_hyperplane(hyperplane, o, cut);
    const auto held = volume->coefficients(o.channel, o.kernel, o.level, cut.reads(volume->lattice(o.level)));
    const Coefficients& coefficients = *held;
    const Token token = read_token(o.cancel_token);
    Progress progress(progress_callback(o.progress, o.progress_user), true);
    watch(progress, token), watch(progress, volume->token);
    progress.throw_if_cancelled();
    Progress making(progress, 0, 0.999); // 1 is for a slice that is there
    const Context context = volume->device->context(making);
    const uint64_t read_before = volume->reader->bytes_read();

    auto result = std::make_unique<bccsplat_slice>();
    result->volume = Ref(const_cast<bccsplat_volume*>(volume));
    result->token = token;
    result->channel = o.channel, result->level = o.level;
    if (o.method == BCCSPLAT_METHOD_EXTRACTED)
      extract(*result, coefficients, h, cut, info.affine, context);
    else
      result->slice = hyperslice(coefficients, h, cut, info.affine, context);
    result->cut = cut;
    result->slice.bytes_read = volume->reader->bytes_read() - read_before;
    const uint64_t bytes = result->extraction ? result->extraction->bytes() : result->slice.bytes();
    result->memory = Reservation(volume->device->memory, bytes, "slice");
    volume->tell_repeats(coefficients);
    progress.report(1);
    *slice = result.release();
  });
}

bccsplat_status bccsplat_volume_prefetch(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane,
                                         const bccsplat_slice_options* options) {
  return guard([&] {
    require(volume, "volume");
    const auto o = read_struct(options, "bccsplat_slice_options");
    HypersliceOptions cut = read_slice_options(o, volume->info());
    const Hyperplane h = read_hyperplane(hyperplane, o, cut);
    if (o.method == BCCSPLAT_METHOD_EXTRACTED)
      fail(Code::unsupported, "prefetch: extracted points read samples on their own");
    const auto coefficients =
        volume->coefficients(o.channel, o.kernel, o.level, cut.reads(volume->lattice(o.level)));
    const Token token = read_token(o.cancel_token);
    Progress progress(progress_callback(o.progress, o.progress_user), true);
    watch(progress, token), watch(progress, volume->token);
    progress.throw_if_cancelled();
    prepare_hyperslice(*coefficients, h, cut, volume->device->context(progress));
    volume->tell_repeats(*coefficients);
    progress.report(1);
  });
}

void bccsplat_slice_retain(bccsplat_slice* slice) { retain(slice); }
void bccsplat_slice_release(bccsplat_slice* slice) { release(slice); }

bccsplat_status bccsplat_slice_get_info(const bccsplat_slice* slice, bccsplat_slice_info* info) {
  return guard([&] {
    require(slice, "slice");
    const Slice& s = slice->slice;
    bccsplat_slice_info out{};
    out.lattice = s.lattice.bcc ? BCCSPLAT_LATTICE_BCC : BCCSPLAT_LATTICE_CC;
    std::copy_n(s.hyperplane.coefficients().begin(), 5, out.hyperplane);
    std::copy(s.origin.begin(), s.origin.end(), out.origin);
    const auto extent = extent_of(*slice);
    for (size_t a = 0; a < 3; ++a) {
      std::copy(s.basis[a].begin(), s.basis[a].end(), out.basis[a]);
      std::copy(extent[a].begin(), extent[a].end(), out.extent[a]);
      out.dims[a] = s.empty() ? 0 : static_cast<uint64_t>(std::floor(extent[a][1] - extent[a][0] + 1e-6)) + 1;
      for (size_t c = 0; c < 3; ++c) out.affine[4 * a + c] = s.slice_to_world.linear[a][c];
      out.affine[4 * a + 3] = s.slice_to_world.offset[a];
    }
    out.affine[15] = 1;
    const auto bounds = slice->extraction ? slice->extraction->bounds() : s.bounds;
    out.bounds[0] = bounds[0], out.bounds[1] = bounds[1];
    out.air = s.air;
    out.points = slice->extraction ? slice->extraction->points() : static_cast<uint64_t>(s.points());
    out.bytes_read = s.bytes_read;
    out.milliseconds = s.milliseconds;
    out.kernel = s.kernel.name.c_str();
    out.level = slice->level;
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_slice_evaluate(const bccsplat_slice* slice, uint64_t n, const double* uvw,
                                        float* values, float* gradients) {
  return guard([&] {
    require(slice, "slice");
    if (n == 0) return;
    require(uvw, "uvw"), require(values, "values");
    require_count(n, sizeof(Vec3), "n");
    Progress progress;
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    const std::span points(reinterpret_cast<const Vec3*>(uvw), n);
    std::span<std::array<float, 3>> slopes;
    if (slice->extraction) {
      if (gradients) fail(Code::unsupported, "slice: extracted points have no gradients");
      const uint64_t outside =
          slice->extraction->sample(points, {values, n}, slice->volume->device->context(progress));
      const uint64_t missing = hide_missing(slice->slice, points, {values, n});
      if (outside > 0) fail(Code::out_of_domain, outside, " of ", n, " points lie outside the domain");
      if (missing > 0) fail(Code::hole, missing, " of ", n, " points lie in holes");
      return;
    }
    if (gradients) slopes = {reinterpret_cast<std::array<float, 3>*>(gradients), n};
    const EvaluateMisses misses =
        sample_points(slice->slice, points, {values, n}, slopes, slice->volume->device->context(progress));
    if (misses.outside > 0)
      fail(Code::out_of_domain, misses.outside, " of ", n, " points lie outside the domain");
    if (misses.holes > 0) fail(Code::hole, misses.holes, " of ", n, " points lie in holes");
  });
}

bccsplat_status bccsplat_slice_sample_grid(const bccsplat_slice* slice, const bccsplat_grid* grid,
                                           float* values) {
  return guard([&] {
    require(slice, "slice"), require(values, "values");
    Grid g;
    if (grid) {
      const auto in = read_struct(grid, "bccsplat_grid");
      require_zero(in.reserved, "bccsplat_grid.reserved");
      require_numbers(in.origin, "bccsplat_grid.origin"), require_numbers(in.step, "bccsplat_grid.step");
      uint64_t samples = 1;
      for (size_t a = 0; a < 3; ++a) {
        if (in.dims[a] == 0 || in.dims[a] > INT32_MAX)
          fail(Code::invalid_argument, "bccsplat_grid.dims[", a, "] is ", in.dims[a], ", not in 1 .. ",
               INT32_MAX);
        require_count(in.dims[a], samples * sizeof(float), "bccsplat_grid.dims, the product,");
        samples *= in.dims[a];
        g.origin[a] = in.origin[a], g.step[a] = in.step[a], g.dims[a] = static_cast<int32_t>(in.dims[a]);
      }
    } else if (slice->slice.empty()) {
      return;
    } else {
      const auto extent = extent_of(*slice);
      for (size_t a = 0; a < 3; ++a) {
        g.origin[a] = extent[a][0], g.step[a] = 1;
        g.dims[a] = static_cast<int32_t>(std::floor(extent[a][1] - extent[a][0] + 1e-6)) + 1;
      }
    }
    Progress progress;
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    const Context context = slice->volume->device->context(progress);
    if (slice->extraction)
      sample_extracted(*slice, g, values, context);
    else
      sample_grid(slice->slice, g, values, context);
  });
}

bccsplat_status bccsplat_slice_get_points(const bccsplat_slice* slice, uint64_t capacity, float* uvw,
                                          float* coefficients, uint64_t* count) {
  return guard([&] {
    require(slice, "slice");
    Progress progress;
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    const uint64_t total = slice->extraction
                               ? slice->extraction->list(capacity, uvw, coefficients, progress)
                               : list_points(slice->slice, capacity, uvw, coefficients, progress);
    if (count) *count = total;
  });
}

} // extern "C"
