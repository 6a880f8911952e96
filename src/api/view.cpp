// SPDX-License-Identifier: Apache-2.0
// Reads views and clips, and the functions of views alone.
#include <algorithm>
#include <cmath>

#include "api/handles.h"
#include "api/host_view.h"
#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace bccsplat::api {
namespace {

ColumnMatrix read_matrix(const double (&m)[16], bool column_major, const char* name) {
  require_numbers(m, name, largest_view);
  ColumnMatrix out;
  for (size_t r = 0; r < 4; ++r)
    for (size_t c = 0; c < 4; ++c) out[4 * r + c] = column_major ? m[4 * c + r] : m[4 * r + c];
  return out;
}

void set_depth_range(MatrixView& view, bccsplat_depth_range range) {
  require_choice(range, BCCSPLAT_DEPTH_RANGE_REVERSED, "depth_range");
  view.minus_one_one = range == BCCSPLAT_DEPTH_RANGE_MINUS_ONE_ONE;
  view.reversed = range == BCCSPLAT_DEPTH_RANGE_REVERSED;
}

MatrixView read_matrices(const bccsplat_view& in) {
  MatrixView m;
  m.world_to_view = read_matrix(in.world_to_view, in.column_major != 0, "bccsplat_view.world_to_view");
  m.projection = read_matrix(in.projection, in.column_major != 0, "bccsplat_view.projection");
  m.y_down = in.y_down != 0;
  set_depth_range(m, in.depth_range);
  (void)sight_of(m, 1, 1); // refuses what cannot be looked through
  return m;
}

// row_floats 0: packed, as long as the frame is wide.
HostPlane read_plane(const float* pixels, int64_t row_bytes, const char* name) {
  if (reinterpret_cast<uintptr_t>(pixels) % alignof(float) != 0)
    fail(Code::invalid_argument, name, " is not aligned to its floats");
  constexpr auto bytes = static_cast<int64_t>(sizeof(float));
  constexpr int64_t longest = int64_t{1} << 40;
  if (row_bytes % bytes != 0 || row_bytes > longest || row_bytes < -longest)
    fail(Code::invalid_argument, name, "_row_bytes is ", row_bytes,
         ", no multiple of 4 that rows may be apart");
  return {pixels, static_cast<std::ptrdiff_t>(row_bytes / bytes)};
}

} // namespace

HostView read_view(const bccsplat_view* view) {
  const auto in = read_struct(view, "bccsplat_view");
  HostView out;
  if (in.use_matrices) {
    if (in.camera) fail(Code::invalid_argument, "bccsplat_view has a camera and matrices");
    out.matrices = read_matrices(in);
  } else if (in.camera) {
    out.camera = read_camera(in.camera);
  }
  require_choice(in.depth_kind, BCCSPLAT_DEPTH_DEVICE, "bccsplat_view.depth_kind");
  switch (in.depth_kind) {
  case BCCSPLAT_DEPTH_DEFAULT:
    out.depth_kind = out.matrices ? DepthKind::device : DepthKind::planar;
    break;
  case BCCSPLAT_DEPTH_RAY:
    out.depth_kind = DepthKind::ray;
    break;
  case BCCSPLAT_DEPTH_DEVICE:
    out.depth_kind = DepthKind::device;
    break;
  default:
    break;
  }
  if (in.depth && out.depth_kind == DepthKind::device) {
    if (!out.matrices) fail(Code::invalid_argument, "bccsplat_view: device depth needs matrices");
    (void)device_depth(*out.matrices);
  }
  out.depth = read_plane(in.depth, in.depth_row_bytes, "bccsplat_view.depth");
  out.background = read_plane(in.background, in.background_row_bytes, "bccsplat_view.background");
  for (size_t a = 0; a < 2; ++a) {
    require_range(in.picture_size[a], 0, most_pixels, "bccsplat_view.picture_size");
    require_range(in.region_begin[a], 0, most_pixels, "bccsplat_view.region_begin");
    out.picture[a] = static_cast<int>(in.picture_size[a]),
    out.begin[a] = static_cast<int>(in.region_begin[a]);
  }
  if ((out.picture[0] == 0) != (out.picture[1] == 0) ||
      (out.picture[0] == 0 && (out.begin[0] != 0 || out.begin[1] != 0)))
    fail(Code::invalid_argument, "bccsplat_view: a part of a picture needs both of picture_size");
  return out;
}

std::vector<Clip> read_clips(const bccsplat_clip* clips, uint64_t count) {
  if (count > BCCSPLAT_MAX_CLIPS)
    fail(Code::invalid_argument, "clips: ", count, " half-spaces; at most ", int{BCCSPLAT_MAX_CLIPS});
  if (count > 0) require(clips, "clips");
  std::vector<Clip> out;
  for (uint64_t n = 0; n < count; ++n) {
    const bccsplat_clip& c = clips[n];
    require_numbers(c.normal, "bccsplat_clip.normal"), require_number(c.offset, "bccsplat_clip.offset");
    require_range(std::hypot(c.normal[0], c.normal[1], c.normal[2]), smallest_length, 2 * largest_number,
                  "bccsplat_clip.normal: its length");
    require_choice(c.space, BCCSPLAT_CLIP_SPACE_VOLUME, "bccsplat_clip.space");
    require_zero(c.reserved, "bccsplat_clip.reserved");
    out.push_back({{vec3(c.normal), c.offset}, c.space == BCCSPLAT_CLIP_SPACE_VOLUME, c.instance});
  }
  return out;
}

std::vector<HalfSpace> read_world_clips(const bccsplat_clip* clips, uint64_t count) {
  std::vector<HalfSpace> planes;
  for (const Clip& c : read_clips(clips, count)) {
    if (c.instance != 0) fail(Code::invalid_argument, "bccsplat_clip.instance: a slice has no instances");
    planes.push_back(c.plane);
  }
  return planes;
}

} // namespace bccsplat::api

namespace {

// The sight of a view that has a camera of its own.
Sight read_sight(const bccsplat_view* view, uint32_t width, uint32_t height) {
  require(view, "view");
  require_pixels(width, height, "view");
  const HostView v = read_view(view);
  if (v.is_default()) fail(Code::invalid_argument, "view: it has neither camera nor matrices");
  return v.sight({}, static_cast<int>(width), static_cast<int>(height));
}

template<class Each>
bccsplat_status each_point(const bccsplat_view* view, uint32_t width, uint32_t height, uint64_t n,
                           const double* in, double* out, const Each& each) {
  return guard([&] {
    const Sight sight = read_sight(view, width, height);
    if (n == 0) return;
    require(in, "points"), require(out, "output");
    require_count(n, sizeof(Vec3), "n");
    for (uint64_t i = 0; i < n; ++i) {
      const Vec3 result = each(sight, Vec3{in[3 * i], in[3 * i + 1], in[3 * i + 2]});
      std::copy(result.begin(), result.end(), out + 3 * i);
    }
  });
}

} // namespace

extern "C" {

bccsplat_status bccsplat_view_project(const bccsplat_view* view, uint32_t width, uint32_t height, uint64_t n,
                                      const double* xyz, double* pixels) {
  return each_point(view, width, height, n, xyz, pixels, [](const Sight& sight, const Vec3& p) {
    return sight.project(p) + Vec3{0.5, 0.5, 0};
  });
}

bccsplat_status bccsplat_view_unproject(const bccsplat_view* view, uint32_t width, uint32_t height,
                                        uint64_t n, const double* pixels, double* xyz) {
  return each_point(view, width, height, n, pixels, xyz, [](const Sight& sight, const Vec3& p) {
    return sight.point(p[0] - 0.5, p[1] - 0.5, p[2]);
  });
}

bccsplat_status bccsplat_make_box_clips(const double box_to_world[16], bccsplat_clip clips[6]) {
  return guard([&] {
    require(box_to_world, "box_to_world"), require(clips, "clips");
    Affine3 box;
    for (size_t r = 0; r < 3; ++r) {
      for (size_t c = 0; c < 4; ++c) require_number(box_to_world[4 * r + c], "box_to_world");
      box.linear[r] = {box_to_world[4 * r], box_to_world[4 * r + 1], box_to_world[4 * r + 2]};
      box.offset[r] = box_to_world[4 * r + 3];
    }
    if (!(std::fabs(box.determinant()) > 0) || !std::isfinite(1 / box.determinant()))
      fail(Code::invalid_argument, "box_to_world: the box has no volume");
    const Affine3 to_box = box.inverse();
    for (size_t n = 0; n < 6; ++n) {
      const size_t axis = n / 2;
      HalfSpace h;
      h.normal[axis] = n % 2 == 0 ? 1 : -1;
      h.offset = n % 2 == 0 ? 0 : 1;
      h = h.seen_through(to_box);
      bccsplat_clip out{};
      std::copy(h.normal.begin(), h.normal.end(), out.normal);
      out.offset = h.offset;
      clips[n] = out;
    }
  });
}

bccsplat_status bccsplat_camera_get_matrices(const bccsplat_camera* camera, uint32_t width, uint32_t height,
                                             double near_distance, double far_distance,
                                             bccsplat_depth_range depth_range, uint32_t y_down,
                                             double world_to_view[16], double projection[16]) {
  return guard([&] {
    require(camera, "camera"), require(world_to_view, "world_to_view"), require(projection, "projection");
    if (width == 0 || height == 0) fail(Code::invalid_argument, "camera: the image has no pixels");
    const WorldCamera c = resolve_camera(read_camera(camera));
    require_number(near_distance, "near_distance", largest_view);
    require_number(far_distance, "far_distance", largest_view);
    if (!(near_distance < far_distance) || (c.perspective && !(near_distance > 0)))
      fail(Code::invalid_argument, "camera: near ", near_distance, " and far ", far_distance,
           " do not follow each other in front of it");
    MatrixView like;
    set_depth_range(like, depth_range);
    like.y_down = y_down != 0;
    const MatrixView m =
        camera_matrices(c, static_cast<double>(height) / width, near_distance, far_distance, like);
    std::copy(m.world_to_view.begin(), m.world_to_view.end(), world_to_view);
    std::copy(m.projection.begin(), m.projection.end(), projection);
  });
}

} // extern "C"
