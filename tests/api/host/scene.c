/* SPDX-License-Identifier: Apache-2.0 */
/* Scene and view: a volume among a host's own things. */
#include "host.h"

#include <math.h>

enum { WIDTH = 48, HEIGHT = 32 };

static bccsplat_camera from_the_front(void) {
  bccsplat_camera c = {.struct_size = sizeof c,
                       .projection = BCCSPLAT_PROJECTION_PERSPECTIVE,
                       .position = {6, 5.5, -30},
                       .target = {6, 5.5, 5},
                       .up = {0, 1, 0},
                       .fovy_degrees = 30};
  return c;
}

static bccsplat_view matrices_of(const bccsplat_camera* camera) {
  SIZED(bccsplat_view, view);
  view.use_matrices = 1;
  OK(bccsplat_camera_get_matrices(camera, WIDTH, HEIGHT, 1, 100, BCCSPLAT_DEPTH_RANGE_DEFAULT, 0,
                                  view.world_to_view, view.projection));
  return view;
}

static double sum_of(const bccsplat_frame* frame) {
  SIZED(bccsplat_plane, plane);
  double sum = 0;
  uint32_t x, y;
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  for (y = 0; y < HEIGHT; ++y)
    for (x = 0; x < WIDTH; ++x) sum += plane.pixels[4 * (WIDTH * y + x) + 3];
  return sum;
}

static void views(void) {
  const bccsplat_camera camera = from_the_front();
  bccsplat_view view = matrices_of(&camera);
  double matrix[16], point[3] = {6, 5.5, 5}, pixel[3], back[3];
  const double box[16] = {2, 0, 0, 1, 0, 3, 0, 2, 0, 0, 4, 3, 0, 0, 0, 1};
  bccsplat_clip faces[6];
  int n;
  OK(bccsplat_view_project(&view, WIDTH, HEIGHT, 1, point, pixel));
  EXPECT(fabs(pixel[0] - WIDTH / 2.0) < 1e-9 && fabs(pixel[1] - HEIGHT / 2.0) < 1e-9);
  EXPECT(fabs(pixel[2] - 35) < 1e-9);
  OK(bccsplat_view_unproject(&view, WIDTH, HEIGHT, 1, pixel, back));
  for (n = 0; n < 3; ++n) EXPECT(fabs(back[n] - point[n]) < 1e-9);
  point[2] = -31;
  OK(bccsplat_view_project(&view, WIDTH, HEIGHT, 1, point, pixel));
  EXPECT(isnan(pixel[0]) && pixel[2] < 0);
  REFUSED(INVALID_ARGUMENT, "view is NULL", bccsplat_view_project(NULL, WIDTH, HEIGHT, 1, point, pixel));
  REFUSED(INVALID_ARGUMENT, "0 x 32", bccsplat_view_unproject(&view, 0, HEIGHT, 1, pixel, point));
  view.use_matrices = 0;
  REFUSED(INVALID_ARGUMENT, "neither", bccsplat_view_project(&view, WIDTH, HEIGHT, 1, point, pixel));
  REFUSED(INVALID_ARGUMENT, "near",
          bccsplat_camera_get_matrices(&camera, WIDTH, HEIGHT, 0, 100, 0, 0, matrix, matrix));
  REFUSED(INVALID_ARGUMENT, "depth_range",
          bccsplat_camera_get_matrices(&camera, WIDTH, HEIGHT, 1, 100, 4, 0, matrix, matrix));
  OK(bccsplat_make_box_clips(box, faces));
  EXPECT(faces[0].normal[0] == 0.5 && faces[0].offset == -0.5);
  EXPECT(faces[5].normal[2] == -0.25 && faces[5].offset == 1.75);
  REFUSED(INVALID_ARGUMENT, "box_to_world is NULL", bccsplat_make_box_clips(NULL, faces));
}

static void renderers(bccsplat_device* device, const bccsplat_volume* volume) {
  const bccsplat_camera camera = from_the_front();
  const bccsplat_view view = matrices_of(&camera);
  const bccsplat_hyperplane plane = at_frame(2);
  const bccsplat_clip half = {.normal = {1, 0, 0}, .offset = -6};
  SIZED(bccsplat_picture_needs, needs);
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  double whole;
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_renderer_create(device, &renderer));
  OK(bccsplat_frame_create(device, WIDTH, HEIGHT, 0, &frame));
  OK(bccsplat_renderer_set_slice(renderer, slice));
  INPUT_SIZES(bccsplat_view, view, bccsplat_renderer_set_view(renderer, in), (void)0);
  OK(bccsplat_renderer_render(renderer, frame));
  whole = sum_of(frame);
  EXPECT(whole > 10);
  OK(bccsplat_renderer_set_clips(renderer, &half, 1));
  OK(bccsplat_renderer_render(renderer, frame));
  EXPECT(sum_of(frame) < 0.8 * whole);
  REFUSED(INVALID_ARGUMENT, "clips is NULL", bccsplat_renderer_set_clips(renderer, NULL, 1));
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_set_view(NULL, &view));
  OK(bccsplat_slice_get_view_needs(slice, &view, &half, 1, WIDTH, HEIGHT, NULL, &needs));
  EXPECT(needs.box[0] >= 2 && needs.seen);
  REFUSED(INVALID_ARGUMENT, "slice is NULL",
          bccsplat_slice_get_view_needs(NULL, &view, &half, 1, WIDTH, HEIGHT, NULL, &needs));
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
}

static void scenes(bccsplat_device* device, const bccsplat_volume* volume) {
  const bccsplat_camera camera = from_the_front();
  const bccsplat_view view = matrices_of(&camera);
  const bccsplat_clip half = {.normal = {1, 0, 0}, .offset = -6};
  SIZED(bccsplat_instance, instance);
  SIZED(bccsplat_camera, fitted);
  SIZED(bccsplat_scene_status, status);
  SIZED(bccsplat_lights, lights);
  bccsplat_scene* scene = NULL;
  bccsplat_frame* frame = NULL;
  uint64_t id = 0;
  uint64_t ranges[2] = {0, 0}, count = 0;
  double bounds[6], whole;
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_scene_create(NULL, &scene));
  OK(bccsplat_scene_create(device, &scene));
  OK(bccsplat_frame_create(device, WIDTH, HEIGHT, BCCSPLAT_FRAME_DEPTH, &frame));
  REFUSED(WRONG_STATE, "no instance", bccsplat_scene_get_bounds(scene, bounds));
  REFUSED(WRONG_STATE, "no instance", bccsplat_scene_fit_camera(scene, 0, 0, 0, WIDTH, HEIGHT, &fitted));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_scene_add(scene, NULL, &instance, &id));
  INPUT_SIZES(bccsplat_instance, instance, bccsplat_scene_add(scene, volume, in, &id),
              bccsplat_scene_remove(scene, id));
  OK(bccsplat_scene_add(scene, volume, NULL, &id));
  OK(bccsplat_scene_get_bounds(scene, bounds));
  EXPECT(bounds[0] == 0 && bounds[3] == NX - 1 && bounds[4] == NY - 1 && bounds[5] == NZ - 1);
  OK(bccsplat_scene_fit_camera(scene, BCCSPLAT_PROJECTION_PERSPECTIVE, 0, 0, WIDTH, HEIGHT, &fitted));
  EXPECT(fabs(fitted.target[0] - (NX - 1) / 2.0) < 1e-9);
  REFUSED(INVALID_ARGUMENT, "time", bccsplat_scene_set_time(scene, INFINITY));
  OK(bccsplat_scene_set_time(scene, 14));
  OUTPUT_SIZES(bccsplat_scene_status, bccsplat_scene_render(scene, &view, frame, NULL, 0, out), (void)0);
  OK(bccsplat_scene_render(scene, &view, frame, NULL, 0, &status));
  EXPECT(status.complete == 1 && status.drawn == 1);
  whole = sum_of(frame);
  EXPECT(whole > 10);
  REFUSED(INVALID_ARGUMENT, "budget_ms", bccsplat_scene_render(scene, &view, frame, NULL, -1, &status));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_scene_render(scene, &view, NULL, NULL, 0, &status));
  OK(bccsplat_scene_set_clips(scene, &half, 1));
  OK(bccsplat_scene_render(scene, &view, frame, NULL, 0, NULL));
  EXPECT(sum_of(frame) < 0.8 * whole);
  REFUSED(INVALID_ARGUMENT, "33 half-spaces", bccsplat_scene_set_clips(scene, &half, 33));
  lights.count = 9;
  REFUSED(INVALID_ARGUMENT, "at most 8", bccsplat_scene_set_lights(scene, &lights));
  OK(bccsplat_scene_set_lights(scene, NULL));
  OK(bccsplat_scene_prefetch(scene, &view, WIDTH, HEIGHT, NULL, 16));
  REFUSED(INVALID_ARGUMENT, "0 x 0", bccsplat_scene_prefetch(scene, &view, 0, 0, NULL, 16));
  OK(bccsplat_scene_get_ranges(scene, &view, WIDTH, HEIGHT, NULL, 16, id, 0, ranges, 1, &count));
  EXPECT(count > 0 && ranges[0] > 0 && ranges[1] > 0);
  REFUSED(NOT_FOUND, "no instance 99",
          bccsplat_scene_get_ranges(scene, &view, WIDTH, HEIGHT, NULL, 16, 99, 0, NULL, 0, &count));
  REFUSED(INVALID_ARGUMENT, "unknown flags",
          bccsplat_scene_get_ranges(scene, &view, WIDTH, HEIGHT, NULL, 16, id, 8, NULL, 0, &count));
  instance.hidden = 1;
  OK(bccsplat_scene_set_instance(scene, id, &instance));
  OK(bccsplat_scene_render(scene, &view, frame, NULL, 0, &status));
  EXPECT(sum_of(frame) == 0 && status.drawn == 0);
  REFUSED(NOT_FOUND, "no instance 99", bccsplat_scene_set_instance(scene, 99, &instance));
  REFUSED(NOT_FOUND, "no instance 99", bccsplat_scene_remove(scene, 99));
  bccsplat_scene_retain(scene);
  bccsplat_scene_release(scene);
  bccsplat_frame_release(frame);
  bccsplat_scene_release(scene);
  bccsplat_scene_release(NULL);
}

void test_scene(void) {
  SIZED(bccsplat_device_options, options);
  bccsplat_device* device = NULL;
  bccsplat_volume* volume;
  options.thread_count = 2;
  OK(bccsplat_device_create(&options, &device));
  write_series(device, scratch("scene.bcc4"));
  volume = open_series(device, scratch("scene.bcc4"));
  views();
  renderers(device, volume);
  scenes(device, volume);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
}
