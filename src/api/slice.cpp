// SPDX-License-Identifier: Apache-2.0
// The slice functions of the C API.
#include <algorithm>
#include <cmath>
#include <span>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/slice_options.h"
#include "api/structs.h"

using namespace bccsplat;
using namespace bccsplat::api;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(std::array<float, 3>) == 3 * sizeof(float));

namespace {

SliceRequest read_request(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane,
                          const bccsplat_slice_options& options) {
  HypersliceOptions cut = read_slice_options(options, volume->file);
  cut.merge_later = volume->device->draws_by_gpu();
  const Hyperplane h = read_hyperplane(hyperplane, options, cut);
  return request_slice(volume->file, options.channel, options.kernel, options.level, h, cut);
}

// A cut that a host asks for, with the progress that it is told.
struct Asked {
  bccsplat_slice_options options;
  SliceRequest request;
  Token token;
  Progress progress;

  Asked(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane, const bccsplat_slice_options* o)
      : options(read_struct(o, "bccsplat_slice_options")), request(read_request(volume, hyperplane, options)),
        token(read_token(options.cancel_token)),
        progress(progress_callback(options.progress, options.progress_user), true) {
    watch(progress, token), watch(progress, volume->token);
    progress.throw_if_cancelled();
  }
};

} // namespace

extern "C" {

bccsplat_status bccsplat_slice_create(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane,
                                      const bccsplat_slice_options* options, bccsplat_slice** slice) {
  return guard([&] {
    require(slice, "slice");
    *slice = nullptr;
    require(volume, "volume");
    Asked asked(volume, hyperplane, options);
    Progress making(asked.progress, 0, 0.999); // 1 is for a slice that is there
    auto result = std::make_unique<bccsplat_slice>();
    result->volume = Ref(const_cast<bccsplat_volume*>(volume));
    result->token = asked.token;
    result->open = cut_slice(volume->file, asked.request, volume->device->context(making));
    volume->note_repeats(*asked.request.coefficients);
    if (const double lacking = result->open.slice.lacking; lacking > 1)
      volume->device->log(BCCSPLAT_LOG_WARNING,
                          concat("slice: the closest samples of an axis would need planes ", lacking,
                                 " times as close: what is between them is drawn coarser"));
    asked.progress.report(1);
    *slice = result.release();
  });
}

bccsplat_status bccsplat_volume_slice_at(const bccsplat_volume* volume, double time,
                                         const bccsplat_slice_options* options, bccsplat_slice** slice) {
  bccsplat_hyperplane now{};
  now.struct_size = sizeof now, now.d = 1;
  const bccsplat_status found = guard([&] {
    require(slice, "slice");
    *slice = nullptr;
    require(volume, "volume");
    if (!volume->file.info().lattice.is_static()) now.e = -volume->file.times().index_of(time);
  });
  return found == BCCSPLAT_OK ? bccsplat_slice_create(volume, &now, options, slice) : found;
}

bccsplat_status bccsplat_volume_prefetch(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane,
                                         const bccsplat_slice_options* options) {
  return guard([&] {
    require(volume, "volume");
    Asked asked(volume, hyperplane, options);
    if (asked.request.cut.method == SliceMethod::extracted)
      fail(Code::unsupported, "prefetch: extracted points read samples on their own");
    prefetch_slice(volume->file, asked.request, volume->device->context(asked.progress));
    volume->note_repeats(*asked.request.coefficients);
    asked.progress.report(1);
  });
}

void bccsplat_slice_retain(bccsplat_slice* slice) { retain(slice); }
void bccsplat_slice_release(bccsplat_slice* slice) { release(slice); }

bccsplat_status bccsplat_slice_get_info(const bccsplat_slice* slice, bccsplat_slice_info* info) {
  return guard([&] {
    require(slice, "slice");
    const OpenSlice& open = slice->open;
    const Slice& s = open.slice;
    bccsplat_slice_info out{};
    out.lattice = s.lattice.bcc ? BCCSPLAT_LATTICE_BCC : BCCSPLAT_LATTICE_CC;
    std::copy_n(s.hyperplane.coefficients().begin(), 5, out.hyperplane);
    std::copy(s.origin.begin(), s.origin.end(), out.origin);
    const auto extent = open.extent();
    for (size_t a = 0; a < 3; ++a) {
      std::copy(s.basis[a].begin(), s.basis[a].end(), out.basis[a]);
      std::copy(extent[a].begin(), extent[a].end(), out.extent[a]);
      out.dims[a] = s.empty() ? 0 : static_cast<uint64_t>(std::floor(extent[a][1] - extent[a][0] + 1e-6)) + 1;
      for (size_t c = 0; c < 3; ++c) out.affine[4 * a + c] = s.slice_to_world.linear[a][c];
      out.affine[4 * a + 3] = s.slice_to_world.offset[a];
    }
    out.affine[15] = 1;
    const auto bounds = open.bounds();
    out.bounds[0] = bounds[0], out.bounds[1] = bounds[1];
    out.air = s.air;
    out.points = open.points();
    out.bytes_read = s.bytes_read;
    out.milliseconds = s.milliseconds;
    out.kernel = s.kernel.name.c_str();
    out.level = open.level;
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
    if (gradients) slopes = {reinterpret_cast<std::array<float, 3>*>(gradients), n};
    const EvaluateMisses misses =
        slice->open.evaluate(points, {values, n}, slopes, slice->volume->device->context(progress));
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
    } else if (slice->open.slice.empty()) {
      return;
    } else {
      g = slice->open.own_grid();
    }
    Progress progress;
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    slice->open.sample(g, values, slice->volume->device->context(progress));
  });
}

bccsplat_status bccsplat_slice_get_points(const bccsplat_slice* slice, uint64_t capacity, float* uvw,
                                          float* coefficients, uint64_t* count) {
  return guard([&] {
    require(slice, "slice");
    Progress progress;
    watch(progress, slice->token);
    progress.throw_if_cancelled();
    const uint64_t total = slice->open.list(capacity, uvw, coefficients, progress);
    if (count) *count = total;
  });
}

} // extern "C"
