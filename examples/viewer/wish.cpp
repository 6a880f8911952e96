// SPDX-License-Identifier: Apache-2.0
#include "viewer/wish.h"

#include "viewer/palette.h"

#include <algorithm>

namespace viewer {

void check(bccsplat_status status) {
  if (status == BCCSPLAT_CANCELLED) throw Cancelled{};
  bccsplat::client::check(status);
}

Look::Look(const Wish& wish, const std::array<double, 2>& range) {
  for (int i = 0; i < curve_points; ++i) {
    const double f = static_cast<double>(i) / (curve_points - 1),
                 value = range[0] + f * (range[1] - range[0]);
    const auto rgb = palette_color(wish.palette, f);
    colors.insert(colors.end(), {value, rgb[0], rgb[1], rgb[2]});
    opacities.insert(opacities.end(), {value, static_cast<double>(wish.opacity[i])});
  }
  function.color_count = function.opacity_count = curve_points;
  function.colors = colors.data(), function.opacities = opacities.data();
}

Options::Options(const Wish& wish, bccsplat_quality quality, bccsplat_cancel_token* token) {
  options.quality = quality, options.cancel_token = token;
  for (const Surface& s : wish.surfaces) {
    bccsplat_iso_surface& made = surfaces.emplace_back();
    made.value = s.value, made.opacity = s.opacity, made.use_color = s.colored ? 1 : 0;
    std::copy(s.color.begin(), s.color.end(), made.color);
  }
  if (!wish.iso || surfaces.empty()) return;
  options.mode = BCCSPLAT_MODE_ISOSURFACE;
  options.surfaces = surfaces.data(), options.surface_count = static_cast<uint32_t>(surfaces.size());
}

std::vector<bccsplat_clip> clips_of(const Wish& wish, const double (&box)[6]) {
  std::vector<bccsplat_clip> clips;
  for (size_t a = 0; a < 3; ++a) {
    if (!wish.open[a]) continue;
    bccsplat_clip& clip = clips.emplace_back();
    clip.normal[a] = 1; // what lies beyond stays
    clip.offset = -(box[a] + wish.open_to[a] * (box[a + 3] - box[a]));
  }
  return clips;
}

} // namespace viewer
