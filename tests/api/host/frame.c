/* SPDX-License-Identifier: Apache-2.0 */
/* Frame: pixels of its own or of the host, and images on disk. */
#include "host.h"

#include <string.h>
#include <unistd.h>

/* Pixel (0, 0) is red of half opacity, in linear light. */
static void copies(bccsplat_frame* frame) {
  static const float red[4] = {0.25f, 0, 0, 0.5f};
  SIZED(bccsplat_plane, plane);
  unsigned char bytes[6 * 8 * 4];
  unsigned short halves[6 * 8 * 4];
  float floats[6 * 40];
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  memcpy(plane.pixels, red, sizeof red);
  OK(bccsplat_frame_copy(frame, BCCSPLAT_FRAME_RGBA, BCCSPLAT_PIXELS_SRGB8, bytes, 0));
  EXPECT(bytes[0] == 188 && bytes[1] == 0 && bytes[3] == 128); /* sRGB of 0.5 */
  OK(bccsplat_frame_copy(frame, BCCSPLAT_FRAME_RGBA, BCCSPLAT_PIXELS_SRGB8_PREMULTIPLIED, bytes + 5 * 32,
                         -32));
  EXPECT(bytes[5 * 32] == 94 && bytes[5 * 32 + 3] == 128); /* from the bottom up */
  OK(bccsplat_frame_copy(frame, BCCSPLAT_FRAME_RGBA, BCCSPLAT_PIXELS_F16, halves, 0));
  EXPECT(halves[0] == 0x3400 && halves[3] == 0x3800);
  OK(bccsplat_frame_copy(frame, BCCSPLAT_FRAME_RGBA, BCCSPLAT_PIXELS_F32, floats, 40 * sizeof(float)));
  EXPECT(memcmp(floats, red, sizeof red) == 0);
  REFUSED(INVALID_ARGUMENT, "RGBA alone",
          bccsplat_frame_copy(frame, BCCSPLAT_FRAME_TIME, BCCSPLAT_PIXELS_SRGB8, bytes, 0));
  REFUSED(INVALID_ARGUMENT, "does not hold", bccsplat_frame_copy(frame, 1, BCCSPLAT_PIXELS_F32, floats, 124));
  REFUSED(INVALID_ARGUMENT, "multiples of 4",
          bccsplat_frame_copy(frame, 1, BCCSPLAT_PIXELS_F32, floats, 130));
  REFUSED(INVALID_ARGUMENT, "pixel format 5", bccsplat_frame_copy(frame, 1, 5, floats, 0));
  REFUSED(INVALID_ARGUMENT, "pixels is NULL", bccsplat_frame_copy(frame, 1, BCCSPLAT_PIXELS_F32, NULL, 0));
  REFUSED(NOT_FOUND, "channel",
          bccsplat_frame_copy(frame, BCCSPLAT_FRAME_VALUE, BCCSPLAT_PIXELS_F32, floats, 0));
}

static void parts(bccsplat_frame* frame) {
  float pixels[2 * 3 * 4];
  SIZED(bccsplat_plane, plane);
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  OK(bccsplat_frame_copy_part(frame, 1, BCCSPLAT_PIXELS_F32, 6, 2, 2, 3, pixels, 0));
  EXPECT(memcmp(pixels + 8, (const char*)(plane.pixels + 6 * 4) + 3 * plane.row_bytes, 2 * 16) == 0);
  REFUSED(INVALID_ARGUMENT, "no part of 8 x 6",
          bccsplat_frame_copy_part(frame, 1, BCCSPLAT_PIXELS_F32, 7, 2, 2, 3, pixels, 0));
  REFUSED(INVALID_ARGUMENT, "no part of 8 x 6",
          bccsplat_frame_copy_part(frame, 1, BCCSPLAT_PIXELS_F32, 0, UINT32_MAX, 2, 3, pixels, 0));
  REFUSED(INVALID_ARGUMENT, "no part of 8 x 6",
          bccsplat_frame_copy_part(frame, 1, BCCSPLAT_PIXELS_F32, 0, 0, 0, 3, pixels, 0));
  REFUSED(INVALID_ARGUMENT, "does not hold",
          bccsplat_frame_copy_part(frame, 1, BCCSPLAT_PIXELS_F32, 0, 0, 2, 3, pixels, 28));
  REFUSED(INVALID_ARGUMENT, "pixels is NULL",
          bccsplat_frame_copy_part(frame, 1, BCCSPLAT_PIXELS_F32, 0, 0, 2, 3, NULL, 0));
}

static void host_planes(bccsplat_device* device) {
  static float rgba[6][8][4], depth[6][8];
  bccsplat_host_plane planes[2] = {{BCCSPLAT_FRAME_RGBA, 0, rgba[5][0], -(int64_t)sizeof rgba[0]},
                                   {BCCSPLAT_FRAME_DEPTH, 0, depth[0], 0}};
  SIZED(bccsplat_plane, plane);
  bccsplat_frame* frame = NULL;
  OK(bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  EXPECT(plane.pixels == rgba[5][0] && (int64_t)plane.row_bytes == -(int64_t)sizeof rgba[0]);
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_DEPTH, &plane));
  EXPECT(plane.pixels == depth[0] && plane.row_bytes == sizeof depth[0]);
  bccsplat_frame_release(frame);
  OK(bccsplat_frame_wrap_planes(device, 8, 6, NULL, 0, &frame)); /* all its own */
  bccsplat_frame_release(frame);
  REFUSED(INVALID_ARGUMENT, "planes is NULL", bccsplat_frame_wrap_planes(device, 8, 6, NULL, 1, &frame));
  REFUSED(INVALID_ARGUMENT, "0 x 6", bccsplat_frame_wrap_planes(device, 0, 6, planes, 2, &frame));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, NULL));
  planes[1].channel = BCCSPLAT_FRAME_RGBA;
  planes[1].row_bytes = 128;
  REFUSED(INVALID_ARGUMENT, "given twice", bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  planes[1].channel = BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE;
  REFUSED(INVALID_ARGUMENT, "planes[1]: 6 is not one",
          bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  planes[1].channel = BCCSPLAT_FRAME_DEEP;
  REFUSED(INVALID_ARGUMENT, "no pixels", bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  planes[1].channel = BCCSPLAT_FRAME_DEPTH;
  planes[1].row_bytes = -28;
  REFUSED(INVALID_ARGUMENT, "planes[1]: row_bytes -28",
          bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  planes[1].row_bytes = INT64_MIN;
  REFUSED(INVALID_ARGUMENT, "memory", bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  planes[1].row_bytes = 0;
  planes[1].pixels = (float*)((char*)depth + 1);
  REFUSED(INVALID_ARGUMENT, "aligned", bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  planes[1].pixels = depth[0];
  planes[1].reserved = 1;
  REFUSED(INVALID_ARGUMENT, "reserved", bccsplat_frame_wrap_planes(device, 8, 6, planes, 2, &frame));
  EXPECT(!frame);
}

static void channels(bccsplat_frame* frame) {
  SIZED(bccsplat_plane, plane);
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  EXPECT(plane.components == 4 && plane.width == 8 && plane.height == 6 && plane.row_bytes >= 8 * 16);
  plane.pixels[0] = 0.5f; /* the host may write */
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_TIME, &plane));
  EXPECT(plane.components == 1);
  REFUSED(NOT_FOUND, "channel", bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_VALUE, &plane));
  copies(frame);
  REFUSED(INVALID_ARGUMENT, "bit", bccsplat_frame_get_channel(frame, 3, &plane));
  REFUSED(INVALID_ARGUMENT, "bit", bccsplat_frame_get_channel(frame, 0, &plane));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_frame_get_channel(NULL, 1, &plane));
  REFUSED(INVALID_ARGUMENT, "plane is NULL", bccsplat_frame_get_channel(frame, 1, NULL));
  OUTPUT_SIZES(bccsplat_plane, bccsplat_frame_get_channel(frame, 1, out), (void)0);
}

/* Samples along rays, before a picture: after one see renderer.c. */
static void deep_samples(bccsplat_device* device, bccsplat_frame* flat) {
  SIZED(bccsplat_deep, deep);
  bccsplat_frame* frame = NULL;
  OK(bccsplat_frame_create(device, 8, 6, BCCSPLAT_FRAME_DEEP, &frame));
  REFUSED(WRONG_STATE, "nothing was rendered", bccsplat_frame_get_deep(frame, &deep));
  REFUSED(WRONG_STATE, "nothing was rendered", bccsplat_frame_save_deep_exr(frame, scratch("d.exr"), NULL));
  REFUSED(NOT_FOUND, "FRAME_DEEP", bccsplat_frame_get_deep(flat, &deep));
  REFUSED(NOT_FOUND, "FRAME_DEEP", bccsplat_frame_save_deep_exr(flat, scratch("d.exr"), NULL));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_frame_get_deep(NULL, &deep));
  EXPECT(access(scratch("d.exr"), F_OK) != 0);
  bccsplat_frame_release(frame);
}

typedef bccsplat_status (*save_fn)(const bccsplat_frame*, const char*, const bccsplat_image_options*);

static void images(bccsplat_frame* frame, save_fn save, const char* name) {
  SIZED(bccsplat_image_options, options);
  unlink(scratch(name));
  options.overwrite = 1;
  OK(save(frame, scratch(name), NULL));
  EXPECT(access(scratch(name), F_OK) == 0);
  REFUSED(FILE_EXISTS, name, save(frame, scratch(name), NULL));
  INPUT_SIZES(bccsplat_image_options, options, save(frame, scratch(name), in), (void)0);
  REFUSED(INVALID_ARGUMENT, "frame is NULL", save(NULL, scratch(name), &options));
  REFUSED(INVALID_ARGUMENT, "path is NULL", save(frame, NULL, &options));
  options.reserved = 1;
  REFUSED(INVALID_ARGUMENT, "reserved", save(frame, scratch(name), &options));
  options.reserved = 0;
  options.frames_per_second[0] = 24;
  options.frames_per_second[1] = 1;
  options.exposure_seconds = 0.5;
  options.comments = "made by a test";
  OK(save(frame, scratch(name), &options));
  REFUSED(FILE_NOT_FOUND, "no-such", save(frame, scratch("no-such/p"), NULL));
}

static void sequence_options(bccsplat_frame* frame) {
  SIZED(bccsplat_image_options, options);
  options.overwrite = 1;
  options.frames_per_second[0] = 24; /* over 0 */
  REFUSED(INVALID_ARGUMENT, "frames_per_second", bccsplat_frame_save_exr(frame, scratch("p.exr"), &options));
  options.frames_per_second[0] = 0;
  options.exposure_seconds = -1;
  REFUSED(INVALID_ARGUMENT, "exposure_seconds", bccsplat_frame_save_exr(frame, scratch("p.exr"), &options));
}

/* A library without OpenEXR and libpng says so. */
static void no_images(bccsplat_frame* frame, save_fn save) {
  REFUSED(MISSING_FEATURE, "BCCSPLAT_WITH_IMAGE", save(frame, scratch("p"), NULL));
}

/* This host has no OpenGL context, so that nothing can be drawn into its textures. */
static void textures(bccsplat_device* device) {
  SIZED(bccsplat_gl_target, target);
  SIZED(bccsplat_plane, plane);
  bccsplat_frame* frame = NULL;
  bccsplat_status status;
  target.width = 8, target.height = 6;
  REFUSED(INVALID_ARGUMENT, "texture", bccsplat_frame_wrap_gl(device, &target, &frame));
  target.texture = 1;
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_frame_wrap_gl(NULL, &target, &frame));
  REFUSED(INVALID_ARGUMENT, "target is NULL", bccsplat_frame_wrap_gl(device, NULL, &frame));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_frame_wrap_gl(device, &target, NULL));
  target.replace = 2;
  REFUSED(INVALID_ARGUMENT, "replace", bccsplat_frame_wrap_gl(device, &target, &frame));
  target.replace = 0, target.height = 0;
  REFUSED(INVALID_ARGUMENT, "8 x 0", bccsplat_frame_wrap_gl(device, &target, &frame));
  target.height = 6;
  status = bccsplat_frame_wrap_gl(device, &target, &frame);
  if (status == BCCSPLAT_ERROR_MISSING_FEATURE) return; /* built without */
  EXPECT(status == BCCSPLAT_OK);
  REFUSED(NOT_FOUND, "without channel", bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  bccsplat_frame_release(frame);
}

void test_frame(void) {
  static float pixels[6][10][4];
  SIZED(bccsplat_plane, plane);
  bccsplat_device* device = NULL;
  bccsplat_frame* frame = NULL;
  const int with_images = !strstr(bccsplat_build_info(), "image=none");
  OK(bccsplat_device_create(NULL, &device));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_frame_create(NULL, 8, 6, 1, &frame));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_frame_create(device, 8, 6, 1, NULL));
  REFUSED(INVALID_ARGUMENT, "0 x 6", bccsplat_frame_create(device, 0, 6, 1, &frame));
  REFUSED(INVALID_ARGUMENT, "65537", bccsplat_frame_create(device, 8, 65537, 1, &frame));
  REFUSED(INVALID_ARGUMENT, "channel bits", bccsplat_frame_create(device, 8, 6, 1u << 31, &frame));
  EXPECT(!frame);
  OK(bccsplat_frame_create(device, 8, 6, BCCSPLAT_FRAME_TIME, &frame)); /* RGBA is always there */
  bccsplat_frame_retain(frame);
  bccsplat_frame_release(frame);
  channels(frame);
  parts(frame);
  host_planes(device);
  deep_samples(device, frame);
  if (with_images) {
    images(frame, bccsplat_frame_save_png, "p.png");
    images(frame, bccsplat_frame_save_exr, "p.exr");
    sequence_options(frame);
  } else {
    no_images(frame, bccsplat_frame_save_png);
    no_images(frame, bccsplat_frame_save_exr);
  }
  bccsplat_frame_release(frame);

  textures(device);
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_frame_wrap(NULL, 8, 6, pixels[0][0], 0, &frame));
  REFUSED(INVALID_ARGUMENT, "rgba is NULL", bccsplat_frame_wrap(device, 8, 6, NULL, 0, &frame));
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_frame_wrap(device, 8, 6, pixels[0][0], 0, NULL));
  REFUSED(INVALID_ARGUMENT, "8 x 0", bccsplat_frame_wrap(device, 8, 0, pixels[0][0], 0, &frame));
  REFUSED(INVALID_ARGUMENT, "row_bytes", bccsplat_frame_wrap(device, 8, 6, pixels[0][0], 127, &frame));
  REFUSED(INVALID_ARGUMENT, "row_bytes", bccsplat_frame_wrap(device, 8, 6, pixels[0][0], 64, &frame));
  OK(bccsplat_frame_wrap(device, 8, 6, pixels[0][0], sizeof pixels[0], &frame));
  bccsplat_device_release(device); /* the frame keeps it */
  OK(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane));
  EXPECT(plane.pixels == pixels[0][0] && plane.row_bytes == sizeof pixels[0]);
  bccsplat_frame_release(frame);
  bccsplat_frame_retain(NULL);
  bccsplat_frame_release(NULL);
}
