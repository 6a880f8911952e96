/* SPDX-License-Identifier: Apache-2.0 */
/* render_frame FILE.bcc4 OUT.png [TIME]: the smallest host that draws. Opens a volume, cuts a time slice and
 * saves a picture of it in the default view and colours. C99 and the public header only. */
#include <bccsplat.h>

#include <stdio.h>
#include <stdlib.h>

/* Tells what failed; 1 when it did. */
static int failed(const char* what, bccsplat_status status) {
  if (status == BCCSPLAT_OK) return 0;
  fprintf(stderr, "%s: %s (%s)\n", what, bccsplat_last_error(), bccsplat_status_name(status));
  return 1;
}

int main(int argc, char** argv) {
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  bccsplat_volume_info info = {.struct_size = sizeof info};
  bccsplat_hyperplane plane = {.struct_size = sizeof plane};
  bccsplat_image_options image = {.struct_size = sizeof image};
  double index = 0;
  int bad = 1;

  if (argc < 3 || argc > 4) {
    fprintf(stderr, "usage: render_frame FILE.bcc4 OUT.png [TIME]\n");
    return 2;
  }
  if (failed("device", bccsplat_device_create(NULL, &device))) goto done;
  if (failed(argv[1], bccsplat_volume_open_file(device, argv[1], NULL, &volume))) goto done;
  if (failed("info", bccsplat_volume_get_info(volume, &info))) goto done;

  /* A time in the file's unit becomes a frame number, fractional allowed; without one the middle of the
   * series. */
  index = (double)(info.dims[3] - 1) / 2;
  if (argc == 4 && failed("time", bccsplat_volume_time_to_index(volume, strtod(argv[3], NULL), &index)))
    goto done;
  plane.d = 1; /* t - index = 0 */
  plane.e = -index;
  if (failed("slice", bccsplat_slice_create(volume, &plane, NULL, &slice))) goto done;

  if (failed("renderer", bccsplat_renderer_create(device, &renderer))) goto done;
  if (failed("renderer", bccsplat_renderer_set_slice(renderer, slice))) goto done;
  if (failed("frame", bccsplat_frame_create(device, 512, 512, BCCSPLAT_FRAME_RGBA, &frame))) goto done;
  if (failed("render", bccsplat_renderer_render(renderer, frame))) goto done;
  image.overwrite = 1;
  if (failed(argv[2], bccsplat_frame_save_png(frame, argv[2], &image))) goto done;
  bad = 0;

done: /* every release takes NULL; the order is free */
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
  return bad;
}
