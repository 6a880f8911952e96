// SPDX-License-Identifier: Apache-2.0
// Transfer functions that the file's histogram gives, and what the page asks of pictures.
#include <emscripten.h>

#include <algorithm>

#include "json.h"
#include "viewer.h"

using namespace web;

namespace {

constexpr double least_share = 1e-6; // of an axis that a box may have

template<size_t Width> std::string points_text(const double (*points)[Width], uint32_t count) {
  return json(std::span<const double>(points[0], Width * count));
}

} // namespace

extern "C" {

// Makes a look of a channel for a mode; the text has its points.
EMSCRIPTEN_KEEPALIVE int web_look(int channel, int look, int mode) {
  return answer([&] {
    auto out = sized<bccsplat_look>();
    check(bccsplat_volume_get_look(viewer.volume.get(), static_cast<uint32_t>(channel), look, mode, &out));
    viewer.text = Object()
                      .add("kind", static_cast<double>(out.kind))
                      .put("range", json(std::span<const double>(out.range)))
                      .add("iso", out.iso_value)
                      .put("colors", points_text(out.colors, out.color_count))
                      .put("opacities", points_text(out.opacities, out.opacity_count))
                      .text();
  });
}

EMSCRIPTEN_KEEPALIVE void web_set_function(const double* colors, int color_count, const double* opacities,
                                           int opacity_count, double density) {
  viewer.wishes.colors.assign(colors, colors + size_t{4} * static_cast<size_t>(color_count));
  viewer.wishes.opacities.assign(opacities, opacities + size_t{2} * static_cast<size_t>(opacity_count));
  viewer.wishes.density = density;
}

EMSCRIPTEN_KEEPALIVE void web_set_picture(int channel, int mode, int quality, int shading, double iso) {
  Wishes& w = viewer.wishes;
  w.channel = static_cast<uint32_t>(channel), w.mode = mode, w.quality = quality;
  w.shading = shading != 0, w.iso = iso;
}

EMSCRIPTEN_KEEPALIVE void web_set_view(int perspective, double turn_x, double turn_y, double zoom,
                                       double pan_x, double pan_y) {
  Wishes& w = viewer.wishes;
  w.perspective = perspective != 0, w.turn_x = turn_x, w.turn_y = turn_y;
  w.zoom = zoom, w.pan_x = pan_x, w.pan_y = pan_y;
}

// box: x0 y0 z0 x1 y1 z1 as fractions of the domain; what is outside is not drawn. The whole of it cuts
// nothing.
EMSCRIPTEN_KEEPALIVE void web_set_clip(const double* box) {
  viewer.wishes.clips.clear();
  const bool whole = std::all_of(box, box + 3, [](double x) { return x <= 0; }) &&
                     std::all_of(box + 3, box + 6, [](double x) { return x >= 1; });
  if (whole || !viewer.volume) return;
  const double* const to_world = viewer.info.affine;
  double placed[16] = {};
  placed[15] = 1;
  for (int row = 0; row < 3; ++row) {
    placed[4 * row + 3] = to_world[4 * row + 3];
    for (int a = 0; a < 3; ++a) {
      const double across = to_world[4 * row + a] * samples_across(viewer.info, a);
      placed[4 * row + a] = across * std::max(box[3 + a] - box[a], least_share);
      placed[4 * row + 3] += across * box[a];
    }
  }
  viewer.wishes.clips.resize(6);
  if (bccsplat_make_box_clips(placed, viewer.wishes.clips.data()) != BCCSPLAT_OK) viewer.wishes.clips.clear();
}

} // extern "C"
