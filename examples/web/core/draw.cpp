// SPDX-License-Identifier: Apache-2.0
// Cuts moments and draws them into a texture, and that onto the page's canvas.
#include <emscripten.h>

#include <algorithm>

#include "canvas.h"
#include "json.h"
#include "viewer.h"

namespace web {
namespace {

bool has_labels(uint32_t channel) {
  auto about = sized<bccsplat_channel_info>();
  check(bccsplat_volume_get_channel_info(viewer.volume.get(), channel, &about));
  return about.labels != 0;
}

// No GPU draws labels: pictures are of the field through them, which a lattice that is asked for has.
bccsplat_slice_options slice_options(uint32_t channel, int level) {
  auto options = sized<bccsplat_slice_options>();
  options.channel = channel, options.level = static_cast<uint32_t>(level);
  options.space = BCCSPLAT_SPACE_EVEN;
  if (has_labels(channel)) options.lattice = BCCSPLAT_LATTICE_CC; // which theirs is
  return options;
}

void cut_into(Moment& moment, double time, uint32_t channel, int level,
              bccsplat_space space = BCCSPLAT_SPACE_EVEN) {
  if (moment.is(time, channel, level)) return;
  bccsplat_slice_options options = slice_options(channel, level);
  options.space = space;
  if (space == BCCSPLAT_SPACE_INDEX) options.lattice = BCCSPLAT_LATTICE_DEFAULT; // the labels themselves
  Slice made = make(bccsplat_volume_slice_at, viewer.volume.get(), time, &options);
  moment = {std::move(made), time, channel, level};
}

// The level that a picture takes: told by any slice, of which the coarsest is the cheapest.
int level_for(double time, uint32_t width, uint32_t height) {
  const auto coarsest = static_cast<int>(viewer.info.level_count);
  if (coarsest == 0) return 0;
  const Wishes& w = viewer.wishes;
  if (!viewer.coarse.slice || viewer.coarse.channel != w.channel)
    cut_into(viewer.coarse, time, w.channel, coarsest);
  auto needs = sized<bccsplat_picture_needs>();
  const bccsplat_render_options options = viewer.options();
  check(bccsplat_slice_get_picture_needs(viewer.coarse.slice.get(), &viewer.camera, width, height, &options,
                                         &needs));
  return static_cast<int>(needs.level);
}

void set_function() {
  const Wishes& w = viewer.wishes;
  if (w.colors.empty()) return check(bccsplat_renderer_set_transfer_function(viewer.renderer.get(), nullptr));
  auto f = sized<bccsplat_transfer_function>();
  f.colors = w.colors.data(), f.color_count = static_cast<uint32_t>(w.colors.size() / 4);
  f.opacities = w.opacities.data(), f.opacity_count = static_cast<uint32_t>(w.opacities.size() / 2);
  f.unit_distance = viewer.info.mean_voxel / w.density;
  check(bccsplat_renderer_set_transfer_function(viewer.renderer.get(), &f));
}

std::string camera_text(const bccsplat_camera& c) {
  return Object()
      .put("position", json(std::span<const double>(c.position)))
      .put("target", json(std::span<const double>(c.target)))
      .put("up", json(std::span<const double>(c.up)))
      .add("perspective", c.projection == BCCSPLAT_PROJECTION_PERSPECTIVE ? 1.0 : 0.0)
      .add("fovy", c.fovy_degrees)
      .add("height", c.ortho_height)
      .text();
}

void draw(uint32_t width, uint32_t height) {
  bccsplat_renderer* const r = viewer.renderer.get();
  check(bccsplat_renderer_set_slice(r, viewer.moment.slice.get()));
  check(bccsplat_renderer_set_camera(r, &viewer.camera));
  check(bccsplat_renderer_set_clips(r, viewer.wishes.clips.data(), viewer.wishes.clips.size()));
  const bccsplat_render_options options = viewer.options();
  check(bccsplat_renderer_set_options(r, &options));
  set_function();
  check(bccsplat_renderer_render(r, canvas_frame(width, height)));
}

} // namespace

bccsplat_render_options Viewer::options() const {
  auto o = sized<bccsplat_render_options>();
  o.mode = wishes.mode, o.quality = wishes.quality;
  o.shading = wishes.shading ? BCCSPLAT_SHADING_DEFAULT : BCCSPLAT_SHADING_OFF;
  o.set_mask = BCCSPLAT_RENDER_SET_ISO, o.iso_value = wishes.iso;
  return o;
}

void Viewer::cut(double time, uint32_t width, uint32_t height, bool preview, bool planes) {
  fit(width, height);
  const int level = preview ? static_cast<int>(info.level_count) : level_for(time, width, height);
  cut_into(moment, time, wishes.channel, level);
  if (planes && has_labels(wishes.channel))
    cut_into(samples, time, wishes.channel, 0, BCCSPLAT_SPACE_INDEX);
  else
    samples = {};
}

} // namespace web

using namespace web;

extern "C" {

// Makes a moment ready for a picture, and for planes; preview: at the coarsest level, whatever the picture
// takes.
EMSCRIPTEN_KEEPALIVE int web_cut(double time, int width, int height, int preview, int planes) {
  return answer([&] {
    viewer.cut(time, static_cast<uint32_t>(width), static_cast<uint32_t>(height), preview != 0, planes != 0);
  });
}

// Draws the moment that is cut; X-rays are exposed as the last one was, or where that is not kept so that
// the brightest pixels are white. The text is the camera and what it took.
EMSCRIPTEN_KEEPALIVE int web_draw(int width, int height, double red, double green, double blue,
                                  int keep_exposure) {
  return answer([&] {
    const double start = emscripten_get_now();
    viewer.fit(static_cast<uint32_t>(width), static_cast<uint32_t>(height));
    draw(static_cast<uint32_t>(width), static_cast<uint32_t>(height));
    const bool x_ray = viewer.wishes.mode == BCCSPLAT_MODE_XRAY;
    static double exposure = 1;
    if (const double most = x_ray && keep_exposure == 0 ? white_pixel() : 0; most > 0) exposure = 1 / most;
    show_canvas({red, green, blue}, x_ray ? exposure : 0);
    viewer.text = Object()
                      .put("camera", camera_text(viewer.camera))
                      .add("level", static_cast<double>(viewer.moment.level))
                      .add("ms", emscripten_get_now() - start)
                      .text();
  });
}

// The byte ranges that cutting these times lacks; returns how many pairs of offset and size are known, or
// minus a status.
EMSCRIPTEN_KEEPALIVE int web_ranges(double from, double to, double* pairs, int capacity) {
  uint64_t count = 0;
  std::vector<uint64_t> ranges(2 * static_cast<size_t>(capacity));
  const int status = answer([&] {
    const int level = std::max(viewer.moment.level, 0);
    bccsplat_slice_options options = slice_options(viewer.wishes.channel, level);
    double first = 0, last = 0;
    check(bccsplat_volume_time_to_index(viewer.volume.get(), from, &first));
    check(bccsplat_volume_time_to_index(viewer.volume.get(), to, &last));
    auto now = sized<bccsplat_hyperplane>();
    now.d = 1, now.e = -first;
    options.interval[1] = last - first;
    check(bccsplat_volume_get_ranges(viewer.volume.get(), &now, &options, BCCSPLAT_RANGES_MISSING,
                                     ranges.data(), static_cast<uint64_t>(capacity), &count));
  });
  if (status != BCCSPLAT_OK) return -status;
  const auto known = static_cast<size_t>(std::min<uint64_t>(count, static_cast<uint64_t>(capacity)));
  for (size_t n = 0; n < 2 * known; ++n) pairs[n] = static_cast<double>(ranges[n]);
  return static_cast<int>(known);
}

} // extern "C"
