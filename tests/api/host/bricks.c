/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks: a time slice as what a host uploads to its GPU. */
#include "host.h"

#include <math.h>
#include <stdlib.h>

/* Bricks of 8 samples and a border: the value of one sample, and that a cell holds what is listed. */
static void values(const bccsplat_slice* slice) {
  SIZED(bccsplat_brick_options, options);
  SIZED(bccsplat_brick_info, info);
  const double at[3] = {6, 6, 5};
  float value, *bricks, *bounds;
  uint32_t *index, cells[1] = {0};
  uint64_t count = 0, n, all;
  options.edge = 8;
  options.border = 1;
  OK(bccsplat_slice_get_brick_info(slice, &options, &info));
  EXPECT(info.edge == 10 && info.brick_bytes == 4000 && info.cosets == 1 && info.dims[0] == NX);
  EXPECT(info.bricks[0] == (NX + 7) / 8 && info.scale == 1 && info.offset == 0 && info.empty == 0);
  all = (uint64_t)info.bricks[0] * info.bricks[1] * info.bricks[2];
  index = malloc(all * sizeof *index);
  bounds = malloc(2 * all * sizeof *bounds);
  OK(bccsplat_slice_find_bricks(slice, &options, index, bounds, &count));
  EXPECT(count > 0 && count <= all && index[0] == 1);
  for (n = 0; n < all && bounds[2 * n] <= bounds[2 * n + 1]; ++n) continue;
  EXPECT(n == all);
  bricks = malloc(info.brick_bytes);
  OK(bccsplat_slice_get_bricks(slice, &options, 1, cells, bricks, NULL));
  OK(bccsplat_slice_evaluate(slice, 1, at, &value, NULL));
  EXPECT(fabs(bricks[7 + 10 * (7 + 10 * 6)] - value) < 1e-4);
  OK(bccsplat_slice_get_bricks(slice, &options, 0, NULL, NULL, NULL));
  OK(bccsplat_slice_find_bricks(slice, NULL, NULL, NULL, &n));
  EXPECT(n == 1);

  cells[0] = (uint32_t)all;
  REFUSED(INVALID_ARGUMENT, "no brick", bccsplat_slice_get_bricks(slice, &options, 1, cells, bricks, NULL));
  REFUSED(INVALID_ARGUMENT, "slice is NULL",
          bccsplat_slice_get_bricks(NULL, &options, 1, cells, bricks, NULL));
  REFUSED(INVALID_ARGUMENT, "cells is NULL",
          bccsplat_slice_get_bricks(slice, &options, 1, NULL, bricks, NULL));
  REFUSED(INVALID_ARGUMENT, "values is NULL",
          bccsplat_slice_get_bricks(slice, &options, 1, cells, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "count",
          bccsplat_slice_get_bricks(slice, &options, UINT64_MAX, cells, bricks, NULL));
  free(index), free(bounds), free(bricks);
}

static void wrong_options(const bccsplat_slice* slice) {
  SIZED(bccsplat_brick_info, info);
  SIZED(bccsplat_brick_options, options);
#define WRONG(status, word, ...)                                                                             \
  do {                                                                                                       \
    SIZED(bccsplat_brick_options, o);                                                                        \
    __VA_ARGS__;                                                                                             \
    REFUSED(status, word, bccsplat_slice_get_brick_info(slice, &o, &info));                                  \
    REFUSED(status, word, bccsplat_slice_find_bricks(slice, &o, NULL, NULL, NULL));                          \
  } while (0)
  WRONG(INVALID_ARGUMENT, "edge", o.edge = 3);
  WRONG(INVALID_ARGUMENT, "edge", o.edge = 129);
  WRONG(INVALID_ARGUMENT, "border", o.border = 17);
  WRONG(INVALID_ARGUMENT, "grid", o.grid = 3);
  WRONG(INVALID_ARGUMENT, "type", o.type = BCCSPLAT_TYPE_I16);
  WRONG(INVALID_ARGUMENT, "reserved", o.reserved = 1);
  WRONG(INVALID_ARGUMENT, "spacing", o.spacing = -1);
  WRONG(INVALID_ARGUMENT, "spacing", o.spacing = NAN);
  WRONG(INVALID_ARGUMENT, "range", o.range[0] = 1);
  WRONG(INVALID_ARGUMENT, "range", o.range[0] = o.range[1] = 1);
  WRONG(LIMIT_EXCEEDED, "samples along an axis", o.spacing = 1e-9);
  WRONG(LIMIT_EXCEEDED, "bricks", o.spacing = 1e-4; o.edge = 4);
#undef WRONG
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_get_brick_info(NULL, NULL, &info));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_slice_get_brick_info(slice, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "slice is NULL", bccsplat_slice_find_bricks(NULL, NULL, NULL, NULL, NULL));
  options.edge = 8;
  INPUT_SIZES(bccsplat_brick_options, options, bccsplat_slice_get_brick_info(slice, in, &info), (void)0);
  OUTPUT_SIZES(bccsplat_brick_info, bccsplat_slice_get_brick_info(slice, NULL, out), (void)0);
}

void test_bricks(void) {
  bccsplat_device* device = NULL;
  bccsplat_volume* volume;
  bccsplat_slice* slice = NULL;
  SIZED(bccsplat_slice_options, options);
  SIZED(bccsplat_brick_info, info);
  bccsplat_cancel_token* token = NULL;
  const bccsplat_hyperplane plane = at_frame(2);
  OK(bccsplat_device_create(NULL, &device));
  volume = open_series(device, scratch("s.bcc4"));
  OK(bccsplat_cancel_token_create(&token));
  options.cancel_token = token;
  OK(bccsplat_slice_create(volume, &plane, &options, &slice));
  values(slice);
  wrong_options(slice);
  OK(bccsplat_cancel_token_cancel(token));
  EXPECT(bccsplat_slice_get_brick_info(slice, NULL, &info) == BCCSPLAT_CANCELLED);
  bccsplat_slice_release(slice);
  bccsplat_cancel_token_release(token);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
}
