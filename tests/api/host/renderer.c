/* SPDX-License-Identifier: Apache-2.0 */
/* Renderer: what it is given is checked when it is given; a picture out of order is refused. */
#include "host.h"

#include <math.h>
#include <string.h>

static int32_t cancel_at_once(void* user, double fraction) {
  (void)fraction;
  ++*(int*)user;
  return 1;
}

static void cameras(bccsplat_renderer* renderer) {
  bccsplat_camera right = {.struct_size = sizeof right,
                           .position = {5, 5, -40},
                           .target = {5, 5, 5},
                           .up = {0, 1, 0},
                           .ortho_height = 20};
#define WRONG(...)                                                                                           \
  do {                                                                                                       \
    bccsplat_camera c = right;                                                                               \
    __VA_ARGS__;                                                                                             \
    REFUSED(INVALID_ARGUMENT, "camera", bccsplat_renderer_set_camera(renderer, &c));                         \
  } while (0)
  WRONG(c.projection = 7);
  WRONG(c.position[2] = 5);
  WRONG(c.up[1] = 0);
  WRONG(c.up[1] = 0, c.up[2] = 1);
  WRONG(c.target[0] = NAN);
  WRONG(c.ortho_height = 0);
  WRONG(c.projection = BCCSPLAT_PROJECTION_PERSPECTIVE, c.fovy_degrees = 180);
#undef WRONG
  INPUT_SIZES(bccsplat_camera, right, bccsplat_renderer_set_camera(renderer, in), (void)0);
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_camera(NULL, &right));
  OK(bccsplat_renderer_set_camera(renderer, NULL));
}

static const double colors[] = {0, 0, 0, 1, 100, 1, 1, 0}, opacities[] = {0, 0, 100, 0.5};
static bccsplat_transfer_function function(void) {
  bccsplat_transfer_function f = {.struct_size = sizeof f,
                                  .color_count = 2,
                                  .colors = colors,
                                  .opacities = opacities,
                                  .opacity_count = 2};
  return f;
}

static void functions(bccsplat_renderer* renderer) {
  const double falling[] = {1, 0, 0, 0.5}, opaque[] = {0, 1.5, 1, 1}, nan[] = {0, NAN, 1, 1};
#define WRONG(word, ...)                                                                                     \
  do {                                                                                                       \
    bccsplat_transfer_function f = function();                                                               \
    __VA_ARGS__;                                                                                             \
    REFUSED(INVALID_ARGUMENT, word, bccsplat_renderer_set_transfer_function(renderer, &f));                  \
  } while (0)
  WRONG("colors is NULL", f.colors = NULL);
  WRONG("opacities is NULL", f.opacities = NULL);
  WRONG("transfer function", f.opacities = falling);
  WRONG("transfer function", f.opacities = opaque);
  WRONG("transfer function", f.opacities = nan);
  WRONG("unit_distance", f.unit_distance = -1);
  WRONG("reserved", f.reserved = 1);
#undef WRONG
  INPUT_SIZES(bccsplat_transfer_function, function(), bccsplat_renderer_set_transfer_function(renderer, in),
              (void)0);
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_transfer_function(NULL, NULL));
  OK(bccsplat_renderer_set_transfer_function(renderer, NULL));
}

static void lights(bccsplat_renderer* renderer) {
  const bccsplat_light light = {{0, 0, -1}, {1, 1, 1}}, bad = {{0, NAN, 0}, {1, 1, 1}};
  bccsplat_lights right = {.struct_size = sizeof right, .count = 1, .lights = &light};
#define WRONG(word, ...)                                                                                     \
  do {                                                                                                       \
    bccsplat_lights l = right;                                                                               \
    __VA_ARGS__;                                                                                             \
    REFUSED(INVALID_ARGUMENT, word, bccsplat_renderer_set_lights(renderer, &l));                             \
  } while (0)
  WRONG("lights is NULL", l.lights = NULL);
  WRONG("at most 8", l.count = 9);
  WRONG("direction", l.lights = &bad);
  WRONG("diffuse", l.diffuse = -1);
#undef WRONG
  INPUT_SIZES(bccsplat_lights, right, bccsplat_renderer_set_lights(renderer, in), (void)0);
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_lights(NULL, &right));
  OK(bccsplat_renderer_set_lights(renderer, NULL));
}

static void options(bccsplat_renderer* renderer) {
  SIZED(bccsplat_render_options, right);
#define WRONG(word, ...)                                                                                     \
  do {                                                                                                       \
    SIZED(bccsplat_render_options, o);                                                                       \
    __VA_ARGS__;                                                                                             \
    REFUSED(INVALID_ARGUMENT, word, bccsplat_renderer_set_options(renderer, &o));                            \
  } while (0)
  WRONG("set_mask", o.set_mask = 1u << 31);
  WRONG("mode", o.mode = BCCSPLAT_MODE_MAXIMUM + 1);
  WRONG("mode", o.mode = -1);
  WRONG("quality", o.quality = BCCSPLAT_QUALITY_BEST + 1);
  WRONG("quality", o.quality = -1);
  WRONG("shading", o.shading = 3);
  WRONG("shading", o.shading = -1);
  WRONG("disable_skips", o.disable_skips = 1u << 31);
  WRONG("sheet_step", o.sheet_step = 1e-9);
  WRONG("opacity_stop", o.opacity_stop = 2);
  WRONG("tile_size", o.tile_size = -1);
  WRONG("tile_size", o.tile_size = 4097);
  WRONG("deep_tolerance", o.deep_tolerance = 1.5);
  WRONG("deep_tolerance", o.deep_tolerance = NAN);
  WRONG("preintegrate", o.preintegrate = 3);
  WRONG("preintegrate", o.preintegrate = -1);
  WRONG("smooth_edges", o.smooth_edges = 3);
  WRONG("smooth_edges", o.smooth_edges = -1);
  WRONG("iso_value", o.mode = BCCSPLAT_MODE_ISOSURFACE);
  WRONG("iso_value", o.set_mask = BCCSPLAT_RENDER_SET_ISO, o.iso_value = NAN);
  const bccsplat_iso_surface surface = {0.5, 0.4, {1, 0, 0}, 1, 0}, thick = {0.5, 1.5, {0}, 0, 0},
                             nowhere = {NAN, 1, {0}, 0, 0}, dark = {0.5, 1, {-1, 0, 0}, 1, 0};
  WRONG("surfaces is NULL", o.surface_count = 1);
  WRONG("at most 16", o.surfaces = &surface, o.surface_count = BCCSPLAT_MAX_ISO_SURFACES + 1);
  WRONG("opacity", o.surfaces = &thick, o.surface_count = 1);
  WRONG("value", o.surfaces = &nowhere, o.surface_count = 1);
  WRONG("color", o.surfaces = &dark, o.surface_count = 1);
  SIZED(bccsplat_render_options, one);
  one.mode = BCCSPLAT_MODE_ISOSURFACE, one.surfaces = &surface, one.surface_count = 1;
  OK(bccsplat_renderer_set_options(renderer, &one)); /* needs no iso_value */
  WRONG("gradient_noise", o.set_mask = BCCSPLAT_RENDER_SET_GRADIENT_NOISE, o.gradient_noise = -1);
  WRONG("gradient_noise", o.set_mask = BCCSPLAT_RENDER_SET_GRADIENT_NOISE, o.gradient_noise = NAN);
#undef WRONG
  INPUT_SIZES(bccsplat_render_options, right, bccsplat_renderer_set_options(renderer, in), (void)0);
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_options(NULL, &right));
  OK(bccsplat_renderer_set_options(renderer, NULL));
}

static void trails(bccsplat_renderer* renderer) {
  const bccsplat_transfer_function f = function();
  bccsplat_trail right = {.struct_size = sizeof right, .interval = {-2, 0}, .transfer_function = &f};
  const double bad[] = {0, NAN, 0};
#define WRONG(word, ...)                                                                                     \
  do {                                                                                                       \
    bccsplat_trail t = right;                                                                                \
    __VA_ARGS__;                                                                                             \
    REFUSED(INVALID_ARGUMENT, word, bccsplat_renderer_set_trail(renderer, &t));                              \
  } while (0)
  WRONG("content", t.content = 99);
  WRONG("combine", t.combine = -1);
  WRONG("samples", t.samples = 5000);
  WRONG("sub-intervals", t.intervals = 257);
  WRONG("interval", t.interval[1] = -3);
  WRONG("interval", t.interval[0] = -INFINITY);
  WRONG("colors", t.colors = bad);
  WRONG("reserved", t.reserved = 1);
#undef WRONG
  INPUT_SIZES(bccsplat_trail, right, bccsplat_renderer_set_trail(renderer, in), (void)0);
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_trail(NULL, &right));
  OK(bccsplat_renderer_set_trail(renderer, NULL));
}

static void pictures(bccsplat_renderer* renderer, bccsplat_frame* frame, const bccsplat_slice* oblique) {
  SIZED(bccsplat_render_options, cancel);
  SIZED(bccsplat_render_options, xray);
  SIZED(bccsplat_render_stats, stats);
  bccsplat_trail trail = {.struct_size = sizeof trail, .interval = {-2, 0}};
  int calls = 0;
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_get_stats(renderer, &stats));
  EXPECT(stats.threads == 2 && stats.points_total > 0 && stats.tiles > 0 && stats.ms_total > 0);
  EXPECT(stats.points_splatted > 0 && stats.sheets_reused == 0);
  OK(bccsplat_renderer_render(renderer, frame)); /* keeps its sheets */
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_get_stats(renderer, &stats));
  EXPECT(stats.points_splatted == 0 && stats.sheets_reused > 0);
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_get_stats(NULL, &stats));
  REFUSED(INVALID_ARGUMENT, "stats is NULL", bccsplat_renderer_get_stats(renderer, NULL));
  OUTPUT_SIZES(bccsplat_render_stats, bccsplat_renderer_get_stats(renderer, out), (void)0);
  cancel.progress = cancel_at_once;
  cancel.progress_user = &calls;
  OK(bccsplat_renderer_set_options(renderer, &cancel));
  EXPECT(bccsplat_renderer_render(renderer, frame) == BCCSPLAT_CANCELLED && calls == 1);
  OK(bccsplat_renderer_set_options(renderer, NULL));
  OK(bccsplat_renderer_cancel(renderer)); /* nothing under way: no effect on the next */
  OK(bccsplat_renderer_render(renderer, frame));
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_cancel(NULL));

  OK(bccsplat_renderer_set_trail(renderer, &trail));
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_set_slice(renderer, oblique)); /* along its normal */
  OK(bccsplat_renderer_render(renderer, frame));
  xray.mode = BCCSPLAT_MODE_XRAY;
  OK(bccsplat_renderer_set_options(renderer, &xray));
  REFUSED(UNSUPPORTED, "trail", bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_set_options(renderer, NULL));
  OK(bccsplat_renderer_set_trail(renderer, NULL));
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_set_slice(renderer, oblique)); /* the one it has */
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_renderer_get_stats(renderer, &stats));
  EXPECT(stats.points_splatted == 0 && stats.sheets_reused > 0);
}

/* Samples along rays: composited they are the flat picture of the same render. */
static void deep_pictures(bccsplat_renderer* renderer, bccsplat_device* device) {
  SIZED(bccsplat_deep, deep);
  SIZED(bccsplat_plane, plane);
  SIZED(bccsplat_device_info, info);
  SIZED(bccsplat_image_options, overwrite);
  SIZED(bccsplat_render_options, mip);
  bccsplat_frame* frame = NULL;
  uint64_t held;
  double worst = 0;
  OK(bccsplat_frame_create(device, 40, 30, BCCSPLAT_FRAME_DEEP, &frame));
  OK(bccsplat_device_get_info(device, &info));
  held = info.memory_used;
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  OK(bccsplat_frame_get_deep(frame, &deep));
  EXPECT(deep.components == 6 && deep.width == 40 && deep.height == 30 && deep.sample_count > 0);
  EXPECT(deep.first[0] == 0 && deep.first[40 * 30] == deep.sample_count);
  OK(bccsplat_device_get_info(device, &info));
  EXPECT(info.memory_used >= held + deep.sample_count * 24);
  for (size_t p = 0; p < 40 * 30; ++p) {
    double rgba[4] = {0};
    for (uint64_t n = deep.first[p]; n < deep.first[p + 1]; ++n) {
      const float* s = deep.samples + 6 * n;
      const double passed = 1 - rgba[3];
      EXPECT(s[1] >= s[0] && (n == deep.first[p] || s[0] >= s[-5]));
      for (int c = 0; c < 4; ++c) rgba[c] += passed * (double)s[c < 3 ? 3 + c : 2];
    }
    for (int c = 0; c < 4; ++c) worst = fmax(worst, fabs(rgba[c] - (double)plane.pixels[4 * p + (size_t)c]));
  }
  EXPECT(worst < 1e-5);
  REFUSED(INVALID_ARGUMENT, "deep is NULL", bccsplat_frame_get_deep(frame, NULL));
  OUTPUT_SIZES(bccsplat_deep, bccsplat_frame_get_deep(frame, out), (void)0);
  overwrite.overwrite = 1;
  if (!strstr(bccsplat_build_info(), "image=none"))
    OK(bccsplat_frame_save_deep_exr(frame, scratch("d.exr"), &overwrite));
  mip.mode = BCCSPLAT_MODE_MAXIMUM;
  OK(bccsplat_renderer_set_options(renderer, &mip));
  REFUSED(UNSUPPORTED, "deep", bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_frame_get_deep(frame, &deep)); /* those of the picture before */
  OK(bccsplat_renderer_set_options(renderer, NULL));
  bccsplat_frame_release(frame);
}

void test_renderer(void) {
  SIZED(bccsplat_device_options, two);
  SIZED(bccsplat_render_stats, stats);
  bccsplat_device *device = NULL, *foreign = NULL;
  bccsplat_volume* volume;
  bccsplat_slice *slice = NULL, *oblique = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame *frame = NULL, *foreign_frame = NULL;
  bccsplat_hyperplane plane = at_frame(2);
  two.thread_count = 2;
  OK(bccsplat_device_create(&two, &device));
  OK(bccsplat_device_create(&two, &foreign));
  volume = open_series(device, scratch("r.bcc4"));
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  plane.a = 1;
  OK(bccsplat_slice_create(volume, &plane, NULL, &oblique));
  OK(bccsplat_frame_create(device, 40, 30, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEPTH, &frame));
  OK(bccsplat_frame_create(foreign, 40, 30, BCCSPLAT_FRAME_RGBA, &foreign_frame));

  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_create(device, NULL));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_renderer_create(NULL, &renderer));
  EXPECT(!renderer);
  OK(bccsplat_renderer_create(device, &renderer));
  REFUSED(WRONG_STATE, "set a slice", bccsplat_renderer_render(renderer, frame));
  REFUSED(WRONG_STATE, "nothing was rendered", bccsplat_renderer_get_stats(renderer, &stats));
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_slice(NULL, slice));
  OK(bccsplat_renderer_set_slice(renderer, slice));
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_render(NULL, frame));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_renderer_render(renderer, NULL));
  REFUSED(INVALID_HANDLE, "another device", bccsplat_renderer_render(renderer, foreign_frame));

  cameras(renderer);
  functions(renderer);
  lights(renderer);
  options(renderer);
  trails(renderer);

  /* Nothing but the renderer holds the slice, the volume and the device now. */
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
  bccsplat_renderer_retain(renderer);
  bccsplat_renderer_release(renderer);
  deep_pictures(renderer, device);
  pictures(renderer, frame, oblique);
  OK(bccsplat_renderer_set_slice(renderer, NULL));
  REFUSED(WRONG_STATE, "set a slice", bccsplat_renderer_render(renderer, frame));

  bccsplat_slice_release(oblique);
  bccsplat_renderer_release(renderer);
  bccsplat_renderer_retain(NULL);
  bccsplat_renderer_release(NULL);
  bccsplat_frame_release(frame);
  bccsplat_frame_release(foreign_frame);
  bccsplat_device_release(foreign);
}
