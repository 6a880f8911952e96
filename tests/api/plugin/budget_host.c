/* SPDX-License-Identifier: Apache-2.0 */
/* budget_host SCRATCH: import, slice and render under memory budgets from roomy to hopeless. Whatever the
 * heap really held is compared with the budget: a call does its work within it or fails with MEMORY_BUDGET,
 * and leaves nothing. */
#include <bccsplat.h>

#include "counted_heap.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What may stand outside the budget, bytes: objects, texts, the scratch of two threads, the layer being read,
 * and what the heap rounds small blocks up to. */
static const long beside = 5L << 19;

enum { N = 72, NT = 6, WIDTH = 256, HEIGHT = 256 };
static int failures = 0;
static int done = 0, refused = 0;

static double field(int x, int y, int z, int t) {
  const double dx = x - 36 - 2 * t, dy = y - 36, dz = z - 36 + t;
  return exp(-(dx * dx + dy * dy + dz * dz) / 400) *
         (1 + 0.3 * sin(0.9 * x) * sin(1.1 * y + t) * cos(0.7 * z));
}

/* Ends one step: its status and what the heap held at most. 1 when it worked. */
static int judge(const char* step, bccsplat_status status, uint64_t budget, long before) {
  const long held = heap_peak() - before;
  printf("budget %7.1f MiB  %-7s %-28s heap %7.1f MiB\n", (double)budget / 1048576, step,
         bccsplat_status_name(status), (double)held / 1048576);
  if (status != BCCSPLAT_OK && status != BCCSPLAT_ERROR_MEMORY_BUDGET) {
    printf("  %s\n", bccsplat_last_error());
    ++failures;
  }
  if (budget > 0 && held > (long)budget + beside) {
    printf("  more than the budget\n");
    ++failures;
  }
  status == BCCSPLAT_OK ? ++done : ++refused;
  return status == BCCSPLAT_OK;
}

static bccsplat_device* make_device(uint64_t budget) {
  bccsplat_device_options o = {.struct_size = sizeof o, .thread_count = 2, .memory_budget = budget};
  bccsplat_device* device = NULL;
  if (bccsplat_device_create(&o, &device) != BCCSPLAT_OK) exit(1);
  return device;
}

static bccsplat_status import(uint64_t budget, const char* path, const float* frames) {
  bccsplat_writer_options o = {.struct_size = sizeof o, .dims = {N, N, N, NT}, .overwrite = 1};
  bccsplat_box box = {.struct_size = sizeof box, .type = BCCSPLAT_TYPE_F32, .dims = {N, N, N}};
  bccsplat_device* device = make_device(budget);
  bccsplat_writer* writer = NULL;
  bccsplat_status status = bccsplat_writer_create(device, path, &o, &writer);
  int t;
  for (t = 0; t < NT && status == BCCSPLAT_OK; ++t) {
    box.data = frames + (size_t)t * N * N * N;
    status = bccsplat_writer_add_frame(writer, 0, t, &box, 1);
  }
  if (status == BCCSPLAT_OK) status = bccsplat_writer_finish(writer, NULL);
  bccsplat_writer_release(writer);
  bccsplat_device_release(device);
  return status;
}

/* A slice and a picture of it. */
static void look(uint64_t budget, const char* path, const bccsplat_hyperplane* plane, const char* what,
                 int trail) {
  const long before = heap_bytes();
  bccsplat_trail interval = {.struct_size = sizeof interval, .interval = {-3, 0}};
  bccsplat_device_info info = {.struct_size = sizeof info};
  bccsplat_device* device = make_device(budget);
  bccsplat_volume* volume = NULL;
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  bccsplat_status status;
  heap_reset_peak();
  status = bccsplat_volume_open_file(device, path, NULL, &volume);
  if (status == BCCSPLAT_OK) status = bccsplat_slice_create(volume, plane, NULL, &slice);
  if (judge(what, status, budget, before)) {
    heap_reset_peak();
    status = bccsplat_renderer_create(device, &renderer);
    if (status == BCCSPLAT_OK) status = bccsplat_renderer_set_slice(renderer, slice);
    if (status == BCCSPLAT_OK && trail) status = bccsplat_renderer_set_trail(renderer, &interval);
    if (status == BCCSPLAT_OK)
      status = bccsplat_frame_create(device, WIDTH, HEIGHT, BCCSPLAT_FRAME_RGBA, &frame);
    if (status == BCCSPLAT_OK) status = bccsplat_renderer_render(renderer, frame);
    judge(trail ? "trail" : "picture", status, budget, before);
  }
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
  if (bccsplat_device_get_info(device, &info) != BCCSPLAT_OK || info.memory_used != 0 ||
      (budget > 0 && info.memory_peak > budget)) {
    printf("  the device still counts %llu bytes, at most %llu\n", (unsigned long long)info.memory_used,
           (unsigned long long)info.memory_peak);
    ++failures;
  }
  bccsplat_device_release(device);
  if (heap_bytes() - before > 64 * 1024) { /* what the C library keeps */
    printf("  %ld bytes left behind\n", heap_bytes() - before);
    ++failures;
  }
}

int main(int argc, char** argv) {
  static const double budgets[] = {0, 128, 96, 72, 48, 16, 6, 2, 0.5}; /* MiB; 0: no limit */
  const bccsplat_hyperplane time_slice = {.struct_size = sizeof time_slice, .d = 1, .e = -3.5},
                            oblique = {.struct_size = sizeof oblique, .a = 0.05, .d = 1, .e = -5};
  float* frames = malloc(sizeof *frames * NT * N * N * N);
  char path[4096], again[4096];
  size_t b, i = 0;
  int x, y, z, t;
  if (argc != 2 || !frames) return 2;
  snprintf(path, sizeof path, "%s/budget.bcc4", argv[1]);
  snprintf(again, sizeof again, "%s/budget_again.bcc4", argv[1]);
  for (t = 0; t < NT; ++t)
    for (z = 0; z < N; ++z)
      for (y = 0; y < N; ++y)
        for (x = 0; x < N; ++x) frames[i++] = (float)field(x, y, z, t);
  for (b = 0; b < sizeof budgets / sizeof *budgets; ++b) {
    const uint64_t budget = (uint64_t)(budgets[b] * 1048576);
    const long before = heap_bytes();
    heap_reset_peak();
    judge("import", import(budget, b == 0 ? path : again, frames), budget, before);
    look(budget, path, &time_slice, "slice", 0);
    look(budget, path, &time_slice, "slice", 1);
    look(budget, path, &oblique, "oblique", 0);
  }
  free(frames);
  if (heap_blocks() <= 0) { /* or the heap is not counted at all */
    printf("no block was counted\n");
    ++failures;
  }
  printf("%d steps done, %d refused\n", done, refused);
  return failures || done < 8 || refused < 8;
}
