#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "api/handles.h"
#include "api/structs.h"
#include "slice/plane_slice.h"
#include "slice/sample_grid.h"
#include "slice/time_slice.h"

using namespace bccsplat;
using namespace bccsplat::api;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(std::array<float, 3>) == 3 * sizeof(float));

namespace {

// The frame of a hyperplane that is a time slice, or tilts against one by less than 1e-6 T over the whole
// extent.
std::optional<double> time_slice_frame(const std::array<double, 5>& h, const std::array<uint32_t, 4>& dims) {
  if (h[3] == 0) return std::nullopt;
  double tilt = 0, centre = -h[4] / h[3];
  for (size_t a = 0; a < 3; ++a) {
    const double extent = dims[a] - 1.0;
    tilt += std::fabs(h[a] / h[3]) * extent;
    centre -= h[a] / h[3] * extent / 2;
  }
  if (tilt >= 1e-6) return std::nullopt;
  return centre;
}

std::array<double, 5> normalised(const bccsplat_hyperplane& h) {
  std::array<double, 5> r{h.a, h.b, h.c, h.d, h.e};
  for (const double v : r)
    if (!std::isfinite(v)) fail(Code::invalid_argument, "hyperplane: every coefficient must be finite");
  // Scaled first, so that neither huge nor tiny normals overflow.
  const double largest = std::max({std::fabs(h.a), std::fabs(h.b), std::fabs(h.c), std::fabs(h.d)});
  if (largest == 0) fail(Code::invalid_argument, "hyperplane: the normal (a, b, c, d) is zero");
  for (double& v : r) v /= largest;
  const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  for (double& v : r) v /= length;
  return r;
}

// Slice-space extent: bounding box of the domain.
std::array<std::array<double, 2>, 3> extent_of(const Slice& s) {
  std::array<std::array<double, 2>, 3> extent;
  for (size_t a = 0; a < 3; ++a) {
    const double unit = s.lattice_to_slice.linear[a][a], offset = s.lattice_to_slice.offset[a];
    extent[a] = {offset, offset + unit * s.domain_end[a]};
  }
  return extent;
}

} // namespace

const SplatPoints& bccsplat_slice::points(const Context& context) const {
  const std::scoped_lock lock(mutex_);
  if (!points_) points_ = std::make_unique<const SplatPoints>(make_points(slice, context));
  return *points_;
}

extern "C" {

bccsplat_status bccsplat_slice_create(const bccsplat_volume* volume, const bccsplat_hyperplane* hyperplane,
                                      const bccsplat_slice_options* options, bccsplat_slice** slice) {
  return guard([&] {
    require(slice, "slice");
    *slice = nullptr;
    require(volume, "volume"), require(hyperplane, "hyperplane");
    const auto h = normalised(read_struct(hyperplane, "bccsplat_hyperplane"));
    const auto o = read_struct(options, "bccsplat_slice_options");
    require_zero(o.reserved, "bccsplat_slice_options.reserved");
    if (o.lattice != BCCSPLAT_LATTICE_DEFAULT && o.lattice != BCCSPLAT_LATTICE_BCC)
      fail(Code::unsupported, "slice: the target lattice is BCC");
    if (!(o.interval[0] <= o.interval[1]))
      fail(Code::invalid_argument, "slice: interval[0] is larger than interval[1]");
    const VolumeInfo& info = volume->info();
    const Coefficients& coefficients = volume->coefficients(o.channel, o.kernel);
    Progress progress(progress_callback(o.progress, o.progress_user));
    const Context context = volume->device->context(progress);
    const uint64_t read_before = volume->reader->bytes_read();

    const auto frame = time_slice_frame(h, info.lattice.dims);
    auto result = std::make_unique<bccsplat_slice>();
    result->volume = Ref(const_cast<bccsplat_volume*>(volume));
    result->channel = o.channel;
    if (frame) {
      result->slice = time_slice(coefficients, *frame, {o.interval[0], o.interval[1]}, info.affine, context);
      if (o.interval[0] == 0 && o.interval[1] == 0)
        result->corrections = volume->corrections(o.channel, o.kernel);
    } else {
      if (o.interval[0] != 0 || o.interval[1] != 0)
        fail(Code::unsupported, "slice: an interval belongs to time slices (a = b = c = 0) only");
      PlaneOptions plane;
      if (o.spacing != 0) plane.spacing = o.spacing;
      plane.time_length =
          o.time_length != 0 ? o.time_length : std::cbrt(std::fabs(info.affine.determinant()));
      result->slice = plane_slice(coefficients, h, plane, info.affine, context);
      result->cut.spacing = plane.spacing, result->cut.time_length = plane.time_length;
      result->cut.target = plane.target;
    }
    result->slice.bytes_read = volume->reader->bytes_read() - read_before;
    result->memory = Reservation(volume->device->memory, result->slice.bytes(), "slice");
    *slice = result.release();
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
    std::copy(s.hyperplane.begin(), s.hyperplane.end(), out.hyperplane);
    std::copy(s.origin.begin(), s.origin.end(), out.origin);
    const auto extent = extent_of(s);
    for (size_t a = 0; a < 3; ++a) {
      std::copy(s.basis[a].begin(), s.basis[a].end(), out.basis[a]);
      std::copy(extent[a].begin(), extent[a].end(), out.extent[a]);
      out.dims[a] = static_cast<uint64_t>(std::floor(extent[a][1] - extent[a][0] + 1e-6)) + 1;
      for (size_t c = 0; c < 3; ++c) out.affine[4 * a + c] = s.slice_to_world.linear[a][c];
      out.affine[4 * a + 3] = s.slice_to_world.offset[a];
    }
    out.affine[15] = 1;
    out.bounds[0] = s.bounds[0], out.bounds[1] = s.bounds[1];
    if (slice->corrections) {
      const auto [low, high] = slice->corrections->range(s.frame);
      out.bounds[0] += static_cast<double>(low), out.bounds[1] += static_cast<double>(high);
    }
    out.air = s.air;
    out.points = static_cast<uint64_t>(s.points());
    out.bytes_read = s.bytes_read;
    out.milliseconds = s.milliseconds;
    out.kernel = s.kernel.name.c_str();
    write_struct(info, out, "info");
  });
}

bccsplat_status bccsplat_slice_evaluate(const bccsplat_slice* slice, uint64_t n, const double* uvw,
                                        float* values, float* gradients) {
  return guard([&] {
    require(slice, "slice");
    if (n == 0) return;
    require(uvw, "uvw"), require(values, "values");
    Progress progress;
    const std::span points(reinterpret_cast<const Vec3*>(uvw), n);
    std::span<std::array<float, 3>> slopes;
    if (gradients) slopes = {reinterpret_cast<std::array<float, 3>*>(gradients), n};
    EvaluateMisses misses =
        sample_points(slice->slice, points, {values, n}, slopes, slice->volume->device->context(progress));
    if (slice->corrections) {
      std::vector<Vec4> at;
      for (const Vec3& p : points) at.push_back({p[0], p[1], p[2], slice->slice.frame});
      misses.holes -= slice->corrections->add_to_points(at, {values, n});
    }
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
      for (size_t a = 0; a < 3; ++a) {
        if (in.dims[a] == 0 || in.dims[a] > INT32_MAX)
          fail(Code::invalid_argument, "grid: dims[", a, "] is ", in.dims[a]);
        if (!std::isfinite(in.origin[a]) || !std::isfinite(in.step[a]))
          fail(Code::invalid_argument, "grid: not finite");
        g.origin[a] = in.origin[a], g.step[a] = in.step[a], g.dims[a] = static_cast<int32_t>(in.dims[a]);
      }
    } else {
      const auto extent = extent_of(slice->slice);
      for (size_t a = 0; a < 3; ++a) {
        g.origin[a] = extent[a][0], g.step[a] = 1;
        g.dims[a] = static_cast<int32_t>(std::floor(extent[a][1] - extent[a][0] + 1e-6)) + 1;
      }
    }
    Progress progress;
    sample_grid(slice->slice, g, values, slice->volume->device->context(progress));
    if (slice->corrections) slice->corrections->add_to_grid(slice->slice.frame, g, values);
  });
}

bccsplat_status bccsplat_slice_get_points(const bccsplat_slice* slice, uint64_t capacity, float* uvw,
                                          float* coefficients, uint64_t* count) {
  return guard([&] {
    require(slice, "slice");
    const uint64_t total = list_points(slice->slice, capacity, uvw, coefficients);
    if (count) *count = total;
  });
}

} // extern "C"
