// SPDX-License-Identifier: Apache-2.0
#include "scene/picture_needs.h"

#include <algorithm>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"

using namespace bccsplat;
using namespace bccsplat::api;

extern "C" {

bccsplat_status bccsplat_slice_get_picture_needs(const bccsplat_slice* slice, const bccsplat_camera* camera,
                                                 uint32_t width, uint32_t height,
                                                 const bccsplat_render_options* options,
                                                 bccsplat_picture_needs* needs) {
  return guard([&] {
    require(slice, "slice"), require(camera, "camera");
    check_output(needs, "needs");
    if (width == 0 || height == 0 || width > most_pixels || height > most_pixels)
      fail(Code::invalid_argument, "picture needs: ", width, " x ", height, " pixels");
    const OpenSlice& open = slice->open;
    if (!open.slice.is_time_slice() || open.extraction || open.cut.axes)
      fail(Code::unsupported, "picture needs: of slices in time alone, along the axes of the volume");
    const PictureNeeds found =
        picture_needs(slice->volume->file, open, read_camera(camera), static_cast<int>(width),
                      static_cast<int>(height), read_render_options(options));
    bccsplat_picture_needs out{};
    out.level = static_cast<uint32_t>(found.level);
    out.distances_per_pixel = found.distances_per_pixel;
    out.seen = found.seen;
    std::copy(found.box.begin.begin(), found.box.begin.end(), out.box);
    std::copy(found.box.end.begin(), found.box.end.end(), out.box + 3);
    write_struct(needs, out, "needs");
  });
}

} // extern "C"
