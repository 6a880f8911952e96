// SPDX-License-Identifier: Apache-2.0
#include "scene/picture_needs.h"

#include <algorithm>
#include <vector>

#include "api/handles.h"
#include "api/render_options.h"
#include "api/structs.h"
#include "formats/bcc4/level_error.h"

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
    if (width == 0 || height == 0 || width > 65536 || height > 65536)
      fail(Code::invalid_argument, "picture needs: ", width, " x ", height, " pixels");
    if (!slice->slice.is_time_slice() || slice->extraction || slice->cut.axes)
      fail(Code::unsupported, "picture needs: of slices in time alone, along the axes of the volume");
    const Camera view = read_camera(camera);
    const RenderOptions o = read_render_options(options);
    const int w = width, h = height;
    const bccsplat_volume& volume = *slice->volume.get();
    std::vector<LevelOption> levels;
    for (uint32_t l = 0; l <= volume.info().levels.size(); ++l)
      levels.push_back({distances_per_pixel(slice->slice, volume.lattice(l), view, w, h),
                        level_error(volume.info(), slice->channel, l)});
    bccsplat_picture_needs out{};
    out.level = enough_level(levels, o);
    out.distances_per_pixel = levels.front().per_pixel;
    const Lattice4& lattice = volume.lattice(0);
    IndexBox box;
    for (size_t a = 0; a < 3; ++a) box.end[a] = lattice.domain_end(a);
    if (const auto seen = seen_box(slice->slice, view, w, h))
      box = clip_to_samples(*seen, lattice), out.seen = 1;
    std::copy(box.begin.begin(), box.begin.end(), out.box);
    std::copy(box.end.begin(), box.end.end(), out.box + 3);
    write_struct(needs, out, "needs");
  });
}

} // extern "C"
