/* SPDX-License-Identifier: Apache-2.0 */
/* A host of the build that only reads: opens a file, cuts a moment, and is told what was left out. host FILE
 */
#include <bccsplat.h>

#include <stdio.h>
#include <string.h>

static int failures;

static void expect(int good, const char* what) {
  if (good) return;
  fprintf(stderr, "FAILED: %s; the last error is: %s\n", what, bccsplat_last_error());
  ++failures;
}

/* Cuts the middle of the series and reads its values. */
static bccsplat_slice* read_middle(bccsplat_volume* volume) {
  bccsplat_volume_info info = BCCSPLAT_INIT(bccsplat_volume_info);
  bccsplat_slice* slice = NULL;
  bccsplat_slice_info cut = BCCSPLAT_INIT(bccsplat_slice_info);
  float value = 0;
  double middle[3];
  int a;
  expect(bccsplat_volume_get_info(volume, &info) == BCCSPLAT_OK, "the volume's information");
  expect(bccsplat_volume_slice_at(volume, (info.time_first + info.time_last) / 2, NULL, &slice) ==
             BCCSPLAT_OK,
         "a moment");
  expect(bccsplat_slice_get_info(slice, &cut) == BCCSPLAT_OK, "its information");
  for (a = 0; a < 3; ++a) middle[a] = (cut.extent[a][0] + cut.extent[a][1]) / 2;
  expect(bccsplat_slice_evaluate(slice, 1, middle, &value, NULL) == BCCSPLAT_OK, "a value of it");
  expect(value >= cut.bounds[0] && value <= cut.bounds[1], "which lies in its bounds");
  printf("%d x %d x %d, %d frames; the value of the middle is %g\n", (int)info.dims[0], (int)info.dims[1],
         (int)info.dims[2], (int)info.dims[3], (double)value);
  return slice;
}

/* A plane x = 0 of time is no moment. */
static void ask_for_a_cut(bccsplat_volume* volume) {
  bccsplat_hyperplane plane = BCCSPLAT_INIT(bccsplat_hyperplane);
  bccsplat_slice* slice = NULL;
  plane.a = 1;
  expect(bccsplat_slice_create(volume, &plane, NULL, &slice) == BCCSPLAT_ERROR_MISSING_FEATURE,
         "a cut is missing");
  expect(strstr(bccsplat_last_error(), "BCCSPLAT_WITH_CUTS") != NULL, "the text names the option");
}

static void ask_for_motion(bccsplat_volume* volume) {
  bccsplat_volume_info info = BCCSPLAT_INIT(bccsplat_volume_info);
  bccsplat_slice_options options = BCCSPLAT_INIT(bccsplat_slice_options);
  bccsplat_slice* slice = NULL;
  expect(bccsplat_volume_get_info(volume, &info) == BCCSPLAT_OK, "the volume's information");
  options.motion = BCCSPLAT_MOTION_ON;
  expect(bccsplat_volume_slice_at(volume, (info.time_first + info.time_last) / 2, &options, &slice) ==
             BCCSPLAT_ERROR_MISSING_FEATURE,
         "motion is missing");
  expect(strstr(bccsplat_last_error(), "BCCSPLAT_WITH_MOTION") != NULL, "the text names the option");
}

/* What is not in this build says so, and how it comes in. */
static void ask_for_the_rest(bccsplat_device* device, bccsplat_slice* slice) {
  bccsplat_writer_options options = BCCSPLAT_INIT(bccsplat_writer_options);
  bccsplat_writer* writer = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  expect(bccsplat_writer_create(device, "never.bcc4", &options, &writer) == BCCSPLAT_ERROR_MISSING_FEATURE,
         "a writer is missing");
  expect(strstr(bccsplat_last_error(), "BCCSPLAT_WITH_WRITER") != NULL, "the text names the option");
  expect(bccsplat_renderer_create(device, &renderer) == BCCSPLAT_OK, "a renderer");
  expect(bccsplat_renderer_set_slice(renderer, slice) == BCCSPLAT_OK, "its slice");
  expect(bccsplat_frame_create(device, 8, 8, BCCSPLAT_FRAME_RGBA, &frame) == BCCSPLAT_OK, "a frame");
  expect(bccsplat_renderer_render(renderer, frame) == BCCSPLAT_ERROR_MISSING_FEATURE, "pictures are a GPU's");
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
}

int main(int argc, char** argv) {
  bccsplat_device_options options = BCCSPLAT_INIT(bccsplat_device_options);
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  if (argc != 2) return 2;
  options.backend = BCCSPLAT_BACKEND_CPU;
  expect(bccsplat_device_create(&options, &device) == BCCSPLAT_OK, "a device");
  expect(bccsplat_volume_open_file(device, argv[1], NULL, &volume) == BCCSPLAT_OK, "the file");
  if (volume) {
    bccsplat_slice* slice = read_middle(volume);
    ask_for_a_cut(volume);
    ask_for_motion(volume);
    ask_for_the_rest(device, slice);
    bccsplat_slice_release(slice);
  }
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
  return failures ? 1 : 0;
}
