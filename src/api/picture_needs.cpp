// SPDX-License-Identifier: Apache-2.0
#include "scene/picture_needs.h"

#include <algorithm>

#include "api/handles.h"
#include "api/host_view.h"
#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

void tell_needs(const bccsplat_slice& slice, const Sight& sight, uint32_t width, uint32_t height,
                const bccsplat_render_options* options, bccsplat_picture_needs* needs) {
  const OpenSlice& open = slice.open;
  if (!open.slice.is_time_slice() || open.extraction || open.cut.axes)
    fail(Code::unsupported, "picture needs: of slices in time alone, along the axes of the volume");
  const PictureNeeds found =
      picture_needs(slice.volume->file, open.channel, open.slice, sight, static_cast<int>(width),
                    static_cast<int>(height), read_render_options(options));
  bccsplat_picture_needs out{};
  out.level = static_cast<uint32_t>(found.level);
  out.distances_per_pixel = found.distances_per_pixel;
  out.seen = found.seen;
  std::copy(found.box.begin.begin(), found.box.begin.end(), out.box);
  std::copy(found.box.end.begin(), found.box.end.end(), out.box + 3);
  write_struct(needs, out, "needs");
}

} // namespace

extern "C" {

bccsplat_status bccsplat_slice_get_picture_needs(const bccsplat_slice* slice, const bccsplat_camera* camera,
                                                 uint32_t width, uint32_t height,
                                                 const bccsplat_render_options* options,
                                                 bccsplat_picture_needs* needs) {
  return guard([&] {
    require(slice, "slice"), require(camera, "camera");
    check_output(needs, "needs");
    require_pixels(width, height, "picture needs");
    const Camera c = read_camera(camera);
    tell_needs(*slice, make_sight(c, static_cast<int>(width), static_cast<int>(height)), width, height,
               options, needs);
  });
}

bccsplat_status bccsplat_slice_get_view_needs(const bccsplat_slice* slice, const bccsplat_view* view,
                                              const bccsplat_clip* clips, uint64_t clip_count, uint32_t width,
                                              uint32_t height, const bccsplat_render_options* options,
                                              bccsplat_picture_needs* needs) {
  return guard([&] {
    require(slice, "slice");
    check_output(needs, "needs");
    require_pixels(width, height, "picture needs");
    const HostView v = read_view(view);
    const std::vector<HalfSpace> planes = read_world_clips(clips, clip_count);
    const int w = static_cast<int>(width), h = static_cast<int>(height);
    Sight sight = v.sight(fitted_camera(v, slice->open.slice, w, h), w, h);
    sight.clip = planes;
    tell_needs(*slice, sight, width, height, options, needs);
  });
}

} // extern "C"
