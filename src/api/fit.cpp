// SPDX-License-Identifier: Apache-2.0
// Views that are fitted to a box of the world.
#include <algorithm>
#include <string>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/render_options.h"
#include "api/structs.h"
#include "scene/default_look.h"
#include "scene/seen_box.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

const ViewSide& side_of(bccsplat_side side) {
  switch (side) {
  case BCCSPLAT_SIDE_BACK:
    return back_side;
  case BCCSPLAT_SIDE_ANTERIOR_RAS:
    return anterior_of_ras;
  case BCCSPLAT_SIDE_ANTERIOR_LPS:
    return anterior_of_lps;
  default:
    return front_side;
  }
}

// By the names that NRRD has for worlds, whatever of time stands behind.
bccsplat_side side_of_space(const std::string& space) {
  std::string name;
  for (const char c : space) name += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (name.starts_with("right-anterior-superior") || name == "ras" || name == "rast")
    return BCCSPLAT_SIDE_ANTERIOR_RAS;
  if (name.starts_with("left-posterior-superior") || name == "lps" || name == "lpst")
    return BCCSPLAT_SIDE_ANTERIOR_LPS;
  return BCCSPLAT_SIDE_FRONT;
}

WorldBox read_bounds(const double (&bounds)[6]) {
  require_numbers(bounds, "bccsplat_fit.bounds");
  WorldBox box;
  for (size_t a = 0; a < 3; ++a) {
    box.low[a] = bounds[a], box.high[a] = bounds[a + 3];
    if (!(box.low[a] <= box.high[a]))
      fail(Code::invalid_argument, "bccsplat_fit.bounds: axis ", a, " ends before it begins");
  }
  return box;
}

} // namespace

extern "C" {

bccsplat_status bccsplat_fit_camera(const bccsplat_fit* fit, uint32_t width, uint32_t height,
                                    bccsplat_camera* camera) {
  return guard([&] {
    require(fit, "fit");
    const auto in = read_struct(fit, "bccsplat_fit");
    require_choice(in.projection, BCCSPLAT_PROJECTION_PERSPECTIVE, "bccsplat_fit.projection");
    require_choice(in.side, BCCSPLAT_SIDE_ANTERIOR_LPS, "bccsplat_fit.side");
    require_zero(in.reserved, "bccsplat_fit.reserved");
    require_number(in.rotate_x_degrees, "bccsplat_fit.rotate_x_degrees", largest_turn);
    require_number(in.rotate_y_degrees, "bccsplat_fit.rotate_y_degrees", largest_turn);
    require_pixels(width, height, "camera");
    const bool perspective = in.projection == BCCSPLAT_PROJECTION_PERSPECTIVE;
    write_camera(fit_box(read_bounds(in.bounds), side_of(in.side), perspective, in.rotate_x_degrees,
                         in.rotate_y_degrees, width, height),
                 camera);
  });
}

bccsplat_status bccsplat_volume_get_side(const bccsplat_volume* volume, bccsplat_side* side) {
  return guard([&] {
    require(volume, "volume"), require(side, "side");
    *side = BCCSPLAT_SIDE_FRONT;
    for (const auto& [key, value] : volume->file.info().attributes)
      if (key == "space") *side = side_of_space(value);
  });
}

bccsplat_status bccsplat_slice_get_seen_bounds(const bccsplat_slice* slice,
                                               const bccsplat_transfer_function* transfer_function,
                                               double bounds[6]) {
  return guard([&] {
    require(slice, "slice"), require(bounds, "bounds");
    const OpenSlice& open = slice->open;
    if (open.slice.empty()) fail(Code::wrong_state, "slice: it misses the volume, and has no bounds");
    const TransferFunction function =
        transfer_function ? read_function(transfer_function)
                          : default_function(slice->volume->file, open.channel, open.slice, {});
    const WorldBox box = seen_box(open.slice, function);
    std::copy(box.low.begin(), box.low.end(), bounds),
        std::copy(box.high.begin(), box.high.end(), bounds + 3);
  });
}

} // extern "C"
