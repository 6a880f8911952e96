/* SPDX-License-Identifier: Apache-2.0 */
/* Slice: time, axis and oblique hyperplanes; grids, points and cameras of them. */
#include "host.h"

#include <math.h>
#include <stdlib.h>

static int32_t keep_going(void* user, double fraction) {
  double* last = user;
  EXPECT(fraction >= *last && fraction <= 1);
  *last = fraction;
  return 0;
}

static void wrong_planes(const bccsplat_volume* volume) {
  bccsplat_hyperplane plane = at_frame(2);
  SIZED(bccsplat_slice_options, options);
  bccsplat_slice* slice = NULL;
  double last = 0;
#define WRONG(status, word, ...)                                                                             \
  do {                                                                                                       \
    bccsplat_hyperplane p = at_frame(2);                                                                     \
    SIZED(bccsplat_slice_options, o);                                                                        \
    slice = (bccsplat_slice*)&o;                                                                             \
    __VA_ARGS__;                                                                                             \
    REFUSED(status, word, bccsplat_slice_create(volume, &p, &o, &slice));                                    \
    EXPECT(!slice);                                                                                          \
  } while (0)
  WRONG(INVALID_ARGUMENT, "zero", p.d = 0);
  WRONG(INVALID_ARGUMENT, "finite", p.a = INFINITY);
  WRONG(OUT_OF_DOMAIN, "", p.e = -4.5);
  WRONG(OUT_OF_DOMAIN, "", p.e = 0.1);
  WRONG(NOT_FOUND, "channel 3", o.channel = 3);
  WRONG(NOT_FOUND, "cubic", o.kernel = "cubic");
  WRONG(INVALID_ARGUMENT, "interval", o.interval[0] = 1);
  WRONG(INVALID_ARGUMENT, "interval", o.interval[0] = NAN);
  WRONG(NOT_FOUND, "level 1", o.level = 1);
  WRONG(UNSUPPORTED, "interval", p.a = 1; o.interval[1] = 1);
  WRONG(INVALID_ARGUMENT, "lattice", o.lattice = BCCSPLAT_LATTICE_D4STAR);
  WRONG(INVALID_STRUCT_SIZE, "bccsplat_hyperplane", p.struct_size = 2);
#undef WRONG
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_slice_create(NULL, &plane, NULL, &slice));
  REFUSED(INVALID_ARGUMENT, "hyperplane is NULL", bccsplat_slice_create(volume, NULL, NULL, &slice));
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_create(volume, &plane, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_prefetch(NULL, &plane, NULL));
  REFUSED(INVALID_ARGUMENT, "hyperplane is NULL", bccsplat_volume_prefetch(volume, NULL, NULL));
  OK(bccsplat_volume_prefetch(volume, &plane, NULL));
  INPUT_SIZES(bccsplat_hyperplane, plane, bccsplat_slice_create(volume, in, NULL, &slice),
              bccsplat_slice_release(slice));
  options.progress = keep_going;
  options.progress_user = &last;
  INPUT_SIZES(bccsplat_slice_options, options, bccsplat_slice_create(volume, &plane, in, &slice),
              (bccsplat_slice_release(slice), last = 0));
}

static void evaluate(const bccsplat_slice* slice) {
  const double at[2][3] = {{6, 6, 5}, {NX, 6, 5}};
  float values[2] = {0}, gradients[3];
  OK(bccsplat_slice_evaluate(slice, 0, NULL, NULL, NULL));
  OK(bccsplat_slice_evaluate(slice, 1, at[0], values, gradients));
  EXPECT(fabs(values[0] - 100) < 2 && fabs(gradients[0]) < 2);
  REFUSED(OUT_OF_DOMAIN, "1 of 2", bccsplat_slice_evaluate(slice, 2, at[0], values, NULL));
  EXPECT(isnan(values[1]));
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_evaluate(NULL, 1, at[0], values, NULL));
  REFUSED(INVALID_ARGUMENT, "uvw is NULL", bccsplat_slice_evaluate(slice, 1, NULL, values, NULL));
  REFUSED(INVALID_ARGUMENT, "values is NULL", bccsplat_slice_evaluate(slice, 1, at[0], NULL, NULL));
}

/* Along x through a place: the value there is that of the largest, and what is refused. */
static void pick(const bccsplat_slice* slice) {
  SIZED(bccsplat_ray, ray);
  SIZED(bccsplat_hit, hit);
  SIZED(bccsplat_slice_info, info);
  double at[3] = {0, 6, 5};
  float value = 0;
  int a, b;
  OK(bccsplat_slice_get_info(slice, &info));
  for (a = 0; a < 3; ++a) {
    ray.origin[a] = info.affine[4 * a + 3], ray.direction[a] = info.affine[4 * a];
    for (b = 0; b < 3; ++b) ray.origin[a] += info.affine[4 * a + b] * at[b];
  }
  ray.pick = BCCSPLAT_PICK_MAXIMUM;
  OK(bccsplat_slice_pick(slice, &ray, &hit));
  EXPECT(hit.found == 1 && fabs(hit.uvw[1] - 6) < 1e-9 && fabs(hit.uvw[2] - 5) < 1e-9);
  OK(bccsplat_slice_evaluate(slice, 1, hit.uvw, &value, NULL));
  EXPECT(fabs(value - hit.value) < 1e-4);
  ray.pick = BCCSPLAT_PICK_VALUE, ray.threshold = 1e9;
  OK(bccsplat_slice_pick(slice, &ray, &hit));
  EXPECT(hit.found == 0 && hit.distance == 0);
  ray.pick = 0;
  REFUSED(INVALID_ARGUMENT, "what to look for", bccsplat_slice_pick(slice, &ray, &hit));
  ray.pick = BCCSPLAT_PICK_OPACITY, ray.threshold = 1;
  REFUSED(INVALID_ARGUMENT, "threshold", bccsplat_slice_pick(slice, &ray, &hit));
  ray.threshold = 0.5, ray.direction[0] = ray.direction[1] = ray.direction[2] = 0;
  REFUSED(INVALID_ARGUMENT, "direction", bccsplat_slice_pick(slice, &ray, &hit));
  REFUSED(INVALID_ARGUMENT, "ray is NULL", bccsplat_slice_pick(slice, NULL, &hit));
  REFUSED(INVALID_ARGUMENT, "hit is NULL", bccsplat_slice_pick(slice, &ray, NULL));
}

static void grids(const bccsplat_slice* slice) {
  SIZED(bccsplat_grid, grid);
  static float box[SAMPLES], part[8];
  OK(bccsplat_slice_sample_grid(slice, NULL, box));
  EXPECT(fabs(box[6 + NX * (6 + NY * 5)] - 100) < 2); /* x fastest */
  grid.origin[0] = 6, grid.origin[1] = 6, grid.origin[2] = 5;
  grid.step[0] = grid.step[1] = grid.step[2] = 1;
  grid.dims[0] = grid.dims[1] = grid.dims[2] = 2;
  OK(bccsplat_slice_sample_grid(slice, &grid, part));
  EXPECT(part[1] == box[7 + NX * (6 + NY * 5)] && part[4] == box[6 + NX * (6 + NY * 6)]);
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_sample_grid(NULL, NULL, box));
  REFUSED(INVALID_ARGUMENT, "values is NULL", bccsplat_slice_sample_grid(slice, NULL, NULL));
  INPUT_SIZES(bccsplat_grid, grid, bccsplat_slice_sample_grid(slice, in, part), (void)0);
  grid.reserved = 1;
  REFUSED(INVALID_ARGUMENT, "reserved", bccsplat_slice_sample_grid(slice, &grid, part));
  grid.reserved = 0;
  grid.dims[1] = 0;
  REFUSED(INVALID_ARGUMENT, "dims[1]", bccsplat_slice_sample_grid(slice, &grid, part));
  grid.dims[1] = UINT64_MAX;
  REFUSED(INVALID_ARGUMENT, "dims[1]", bccsplat_slice_sample_grid(slice, &grid, part));
  grid.dims[1] = 2;
  grid.step[2] = NAN;
  REFUSED(INVALID_ARGUMENT, "finite", bccsplat_slice_sample_grid(slice, &grid, part));
}

static void points(const bccsplat_slice* slice) {
  SIZED(bccsplat_slice_info, info);
  uint64_t count = 0, i;
  float *uvw, *coefficients, first[3] = {-7, -7, -7};
  OK(bccsplat_slice_get_info(slice, &info));
  EXPECT(info.dims[0] == NX && info.dims[1] == NY && info.dims[2] == NZ);
  EXPECT(info.hyperplane[3] == 1 && info.origin[3] == 2 && info.basis[1][1] == 1 && info.affine[15] == 1);
  EXPECT(info.bounds[0] <= 0 && info.bounds[1] >= 99 && info.points > 0 && info.kernel[0]);
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_get_info(NULL, &info));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_slice_get_info(slice, NULL));
  OUTPUT_SIZES(bccsplat_slice_info, bccsplat_slice_get_info(slice, out), (void)0);

  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_get_points(NULL, 0, NULL, NULL, &count));
  OK(bccsplat_slice_get_points(slice, 0, NULL, NULL, &count));
  EXPECT(count == info.points);
  uvw = malloc(count * 3 * sizeof *uvw);
  coefficients = malloc(count * sizeof *coefficients);
  OK(bccsplat_slice_get_points(slice, count, uvw, coefficients, NULL));
  OK(bccsplat_slice_get_points(slice, 1, first, NULL, &count));
  EXPECT(count == info.points && memcmp(first, uvw, sizeof first) == 0);
  for (i = 0; i < count; ++i)
    if (!(uvw[3 * i] > -4 && uvw[3 * i] < NX + 3 && isfinite(coefficients[i]))) break;
  EXPECT(i == count);
  free(uvw);
  free(coefficients);
}

static void cameras(const bccsplat_slice* slice) {
  SIZED(bccsplat_camera, camera);
  OK(bccsplat_slice_fit_camera(slice, BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, 64, 48, &camera));
  EXPECT(camera.projection == BCCSPLAT_PROJECTION_PERSPECTIVE && camera.fovy_degrees == 30);
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_fit_camera(NULL, 0, 0, 0, 9, 9, &camera));
  REFUSED(INVALID_ARGUMENT, "camera is NULL", bccsplat_slice_fit_camera(slice, 0, 0, 0, 9, 9, NULL));
  REFUSED(INVALID_ARGUMENT, "projection", bccsplat_slice_fit_camera(slice, 3, 0, 0, 9, 9, &camera));
  REFUSED(INVALID_ARGUMENT, "pixels", bccsplat_slice_fit_camera(slice, 0, 0, 0, 0, 9, &camera));
  REFUSED(INVALID_ARGUMENT, "rotate_x_degrees", bccsplat_slice_fit_camera(slice, 0, NAN, 0, 9, 9, &camera));
  OUTPUT_SIZES(bccsplat_camera, bccsplat_slice_fit_camera(slice, 0, 20, 30, 64, 48, out), (void)0);
}

static void fitted_boxes(const bccsplat_slice* slice) {
  const double colors[4] = {0, 1, 1, 1}, opacities[2] = {0, 1};
  SIZED(bccsplat_transfer_function, all);
  SIZED(bccsplat_fit, fit);
  SIZED(bccsplat_look, look);
  SIZED(bccsplat_camera, camera);
  double bounds[6];
  all.color_count = all.opacity_count = 1;
  all.colors = colors;
  all.opacities = opacities;
  OK(bccsplat_slice_get_seen_bounds(slice, &all, bounds));
  EXPECT(bounds[0] == 0 && bounds[3] == NX - 1);
  OK(bccsplat_slice_get_seen_bounds(slice, NULL, fit.bounds));
  EXPECT(fit.bounds[0] >= 0 && fit.bounds[0] < fit.bounds[3] && fit.bounds[3] <= NX - 1);
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_get_seen_bounds(NULL, NULL, bounds));
  REFUSED(INVALID_ARGUMENT, "bounds is NULL", bccsplat_slice_get_seen_bounds(slice, NULL, NULL));

  OK(bccsplat_slice_get_look(slice, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_DEFAULT, &look));
  EXPECT(look.color_count >= 1 && look.opacity_count >= 1 && look.range[0] <= look.range[1]);
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_get_look(NULL, 0, 0, &look));
  REFUSED(INVALID_ARGUMENT, "out is NULL", bccsplat_slice_get_look(slice, 0, 0, NULL));
  REFUSED(INVALID_ARGUMENT, "look is 8", bccsplat_slice_get_look(slice, 8, 0, &look));
  REFUSED(INVALID_ARGUMENT, "mode is 5", bccsplat_slice_get_look(slice, 0, 5, &look));
  OUTPUT_SIZES(bccsplat_look, bccsplat_slice_get_look(slice, 0, 0, out), (void)0);

  OK(bccsplat_fit_camera(&fit, 64, 48, &camera));
  EXPECT(camera.target[0] == (fit.bounds[0] + fit.bounds[3]) / 2 && camera.up[1] == 1);
  EXPECT(camera.position[0] == camera.target[0] && camera.position[2] > camera.target[2]);
  fit.side = BCCSPLAT_SIDE_ANTERIOR_LPS;
  fit.projection = BCCSPLAT_PROJECTION_PERSPECTIVE;
  OK(bccsplat_fit_camera(&fit, 64, 48, &camera));
  EXPECT(camera.up[2] == 1 && camera.position[1] < camera.target[1] && camera.fovy_degrees == 30);
  REFUSED(INVALID_ARGUMENT, "fit is NULL", bccsplat_fit_camera(NULL, 64, 48, &camera));
  REFUSED(INVALID_ARGUMENT, "camera is NULL", bccsplat_fit_camera(&fit, 64, 48, NULL));
  REFUSED(INVALID_ARGUMENT, "pixels", bccsplat_fit_camera(&fit, 0, 48, &camera));
  fit.side = 5;
  REFUSED(INVALID_ARGUMENT, "side", bccsplat_fit_camera(&fit, 64, 48, &camera));
  fit.side = 0;
  fit.rotate_x_degrees = NAN;
  REFUSED(INVALID_ARGUMENT, "rotate_x_degrees", bccsplat_fit_camera(&fit, 64, 48, &camera));
  fit.rotate_x_degrees = 0;
  fit.bounds[3] = fit.bounds[0] - 1;
  REFUSED(INVALID_ARGUMENT, "ends before", bccsplat_fit_camera(&fit, 64, 48, &camera));
}

static void side_of_volume(const bccsplat_volume* volume) {
  bccsplat_side side = 0;
  OK(bccsplat_volume_get_side(volume, &side));
  EXPECT(side == BCCSPLAT_SIDE_FRONT);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_side(NULL, &side));
  REFUSED(INVALID_ARGUMENT, "side is NULL", bccsplat_volume_get_side(volume, NULL));
}

static void picture_needs(const bccsplat_slice* slice) {
  SIZED(bccsplat_camera, camera);
  SIZED(bccsplat_render_options, options);
  SIZED(bccsplat_picture_needs, needs);
  OK(bccsplat_slice_fit_camera(slice, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 0, 64, 48, &camera));
  OK(bccsplat_slice_get_picture_needs(slice, &camera, 64, 48, NULL, &needs));
  EXPECT(needs.level == 0 && needs.seen == 1 && needs.distances_per_pixel > 0);
  EXPECT(needs.box[0] == 0 && needs.box[3] == NX - 1);
  camera.ortho_height = 1;
  options.quality = BCCSPLAT_QUALITY_DRAFT;
  OK(bccsplat_slice_get_picture_needs(slice, &camera, 64, 48, &options, &needs));
  EXPECT(needs.box[0] > 0 && needs.box[3] < NX - 1 && needs.box[0] < needs.box[3]);
  REFUSED(INVALID_ARGUMENT, "slice is NULL",
          bccsplat_slice_get_picture_needs(NULL, &camera, 9, 9, NULL, &needs));
  REFUSED(INVALID_ARGUMENT, "camera is NULL",
          bccsplat_slice_get_picture_needs(slice, NULL, 9, 9, NULL, &needs));
  REFUSED(INVALID_ARGUMENT, "needs is NULL",
          bccsplat_slice_get_picture_needs(slice, &camera, 9, 9, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "0 pixels", bccsplat_slice_get_picture_needs(slice, &camera, 9, 0, NULL, &needs));
  options.quality = 9;
  REFUSED(INVALID_ARGUMENT, "quality",
          bccsplat_slice_get_picture_needs(slice, &camera, 9, 9, &options, &needs));
  OUTPUT_SIZES(bccsplat_picture_needs, bccsplat_slice_get_picture_needs(slice, &camera, 64, 48, NULL, out),
               (void)0);
}

/* A slice of the mean of frames `first` to `last` against the volume at many moments between them. */
static void expect_mean(const bccsplat_volume* volume, const bccsplat_slice* slice, double first,
                        double last) {
  enum { MOMENTS = 100 };
  const double at[3] = {6, 4, 5};
  double sum = 0;
  float mean, value;
  int i;
  OK(bccsplat_slice_evaluate(slice, 1, at, &mean, NULL));
  for (i = 0; i < MOMENTS; ++i) {
    const double p[4] = {at[0], at[1], at[2], first + (last - first) * (i + 0.5) / MOMENTS};
    OK(bccsplat_volume_evaluate(volume, 1, p, &value, NULL));
    sum += value;
  }
  EXPECT(fabs(mean - sum / MOMENTS) < 0.01 && fabs(mean - value) > 1);
}

void test_slice(void) {
  SIZED(bccsplat_slice_options, mean);
  SIZED(bccsplat_slice_info, info);
  bccsplat_device* device = NULL;
  bccsplat_volume* volume;
  bccsplat_slice* slice = NULL;
  bccsplat_hyperplane plane = at_frame(2);
  OK(bccsplat_device_create(NULL, &device));
  volume = open_series(device, scratch("s.bcc4"));
  wrong_planes(volume);
  side_of_volume(volume);

  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  bccsplat_volume_release(volume); /* the slice keeps both */
  bccsplat_device_release(device);
  bccsplat_slice_retain(slice);
  bccsplat_slice_release(slice);
  evaluate(slice);
  pick(slice);
  grids(slice);
  points(slice);
  cameras(slice);
  fitted_boxes(slice);
  picture_needs(slice);
  bccsplat_slice_release(slice);

  OK(bccsplat_device_create(NULL, &device));
  volume = open_series(device, scratch("s.bcc4"));
  mean.interval[0] = -100; /* clipped to the series */
  OK(bccsplat_slice_create(volume, &plane, &mean, &slice));
  expect_mean(volume, slice, 0, 2);
  bccsplat_slice_release(slice);
  OK(bccsplat_volume_slice_at(volume, 12, NULL, &slice)); /* the time of frame 1 */
  OK(bccsplat_slice_get_info(slice, &info));
  EXPECT(info.hyperplane[3] == 1 && fabs(info.hyperplane[4] + 1) < 1e-12);
  bccsplat_slice_release(slice);
  REFUSED(OUT_OF_DOMAIN, "", bccsplat_volume_slice_at(volume, 9, NULL, &slice));
  EXPECT(!slice);
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_volume_slice_at(volume, 12, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_slice_at(NULL, 12, NULL, &slice));
  plane.a = 1, plane.d = 0, plane.e = -6; /* x = 6 */
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_slice_get_info(slice, &info));
  EXPECT(info.dims[0] == NY && info.dims[2] == NT && info.basis[2][3] == 1);
  bccsplat_slice_release(slice);
  plane.d = 1; /* x + t = 6 */
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_slice_get_info(slice, &info));
  EXPECT(fabs(info.origin[0] + info.origin[3] - 6) < 1e-12 && info.points > 0);
  for (int k = 0; k < 3; ++k) EXPECT(fabs(info.basis[k][0] + info.basis[k][3]) < 1e-12);
  bccsplat_slice_release(slice);
  plane.e = 1000; /* misses the domain: an empty slice */
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_slice_get_info(slice, &info));
  EXPECT(info.points == 0);
  bccsplat_slice_release(slice);
  bccsplat_slice_retain(NULL);
  bccsplat_slice_release(NULL);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
}
