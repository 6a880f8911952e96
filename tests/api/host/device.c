/* SPDX-License-Identifier: Apache-2.0 */
/* Device: threads start late and end with it, its options are checked, its memory is counted. */
#include "host.h"

#include <time.h>
#include <unistd.h>

static void log_to(void* user, int32_t level, const char* message) {
  int* lines = user;
  EXPECT(level == BCCSPLAT_LOG_WARNING || level == BCCSPLAT_LOG_INFO);
  EXPECT(message && *message);
  if (level == BCCSPLAT_LOG_WARNING) ++*lines;
}

/* A runner that goes backwards, in the calling thread. */
static void backwards(void* user, uint64_t count, bccsplat_task_fn body, void* task) {
  ++*(int*)user;
  while (count > 0) body(task, --count);
}

/* One that forgets the last body. */
static void forgetful(void* user, uint64_t count, bccsplat_task_fn body, void* task) {
  uint64_t n;
  (void)user;
  for (n = 0; n + 1 < count; ++n) body(task, n);
}

static void counts(bccsplat_device* device) {
  SIZED(bccsplat_device_info, info);
  OK(bccsplat_device_get_info(device, &info));
  EXPECT(info.thread_count >= 1 && info.memory_budget == UINT64_MAX && info.memory_used == 0);
}

enum { WIDTH = 64, HEIGHT = 48 };
static void draw(bccsplat_device* device, const char* path, float* rgba) {
  const bccsplat_hyperplane plane = at_frame(1.5);
  bccsplat_volume* volume = NULL;
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  OK(bccsplat_volume_open_file(device, path, NULL, &volume));
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_renderer_create(device, &renderer));
  OK(bccsplat_renderer_set_slice(renderer, slice));
  OK(bccsplat_frame_wrap(device, WIDTH, HEIGHT, rgba, 0, &frame));
  OK(bccsplat_renderer_render(renderer, frame));
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
}

static void runners_that_leave_bodies_out(void) {
  SIZED(bccsplat_device_options, o);
  SIZED(bccsplat_render_options, tiles);
  const bccsplat_hyperplane plane = at_frame(1.5);
  bccsplat_device *whole = NULL, *device = NULL;
  bccsplat_volume* volume = NULL;
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  bccsplat_status status;
  OK(bccsplat_device_create(NULL, &whole));
  write_series(whole, scratch("forgotten.bcc4"));
  o.thread_count = 4;
  o.runner = forgetful;
  OK(bccsplat_device_create(&o, &device));
  OK(bccsplat_volume_open_file(device, scratch("forgotten.bcc4"), NULL, &volume));
  status = bccsplat_slice_create(volume, &plane, NULL, &slice); /* a small one may have one body */
  if (status == BCCSPLAT_OK) {
    OK(bccsplat_renderer_create(device, &renderer));
    OK(bccsplat_renderer_set_slice(renderer, slice));
    tiles.tile_size = 16;
    OK(bccsplat_renderer_set_options(renderer, &tiles));
    OK(bccsplat_frame_create(device, WIDTH, HEIGHT, 0, &frame));
    status = bccsplat_renderer_render(renderer, frame);
  }
  EXPECT(status == BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT(strstr(bccsplat_last_error(), "bodies before it returned") != NULL);
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
  bccsplat_device_release(whole);
}

/* Whether there come to be no more than `count` threads: one that was joined may be counted for a moment
 * longer. */
static int comes_to_rest(int count) {
  const time_t start = time(NULL);
  while (thread_count() > count)
    if (difftime(time(NULL), start) > 2) return 0;
  return 1;
}

/* File and picture are the same with one thread, with four, and with a host's runner. */
static void threads_and_runners(void) {
  static float pixels[3][WIDTH * HEIGHT * 4];
  SIZED(bccsplat_device_options, o);
  bccsplat_device* device = NULL;
  unsigned char first[64 * 1024], other[64 * 1024];
  size_t size = 0;
  int calls = 0, way;
  const int at_rest = thread_count();
  for (way = 0; way < 3; ++way) {
    const char* path = scratch("threads.bcc4");
    size_t n;
    FILE* file;
    o.thread_count = way == 0 ? 1 : 4;
    o.runner = way == 2 ? backwards : NULL;
    o.runner_user = &calls;
    OK(bccsplat_device_create(&o, &device));
    EXPECT(comes_to_rest(at_rest)); /* none before there is work */
    write_series(device, path);
    draw(device, path, pixels[way]);
    EXPECT(way == 1 ? thread_count() <= at_rest + 3 : comes_to_rest(at_rest));
    bccsplat_device_release(device);
    EXPECT(comes_to_rest(at_rest)); /* joined */
    file = fopen(path, "rb");
    n = file ? fread(way ? other : first, 1, sizeof first, file) : 0;
    if (file) fclose(file);
    EXPECT(n > 1000 && n < sizeof first);
    EXPECT(way == 0 || (n == size && memcmp(first, other, n) == 0));
    size = n;
  }
  EXPECT(calls > 0);
  EXPECT(memcmp(pixels[0], pixels[1], sizeof pixels[0]) == 0);
  EXPECT(memcmp(pixels[0], pixels[2], sizeof pixels[0]) == 0);
}

static void log_of_damage(void) {
  SIZED(bccsplat_device_options, o);
  SIZED(bccsplat_verify_report, report);
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  static unsigned char bytes[64 * 1024];
  const size_t damaged = 192 + 16; /* of the first chunk: behind the preamble */
  int lines = 0;
  size_t n;
  FILE* file;
  o.log = log_to;
  o.log_user = &lines;
  OK(bccsplat_device_create(&o, &device));
  write_series(device, scratch("damaged.bcc4"));
  EXPECT(lines == 0); /* nothing worth a word */
  file = fopen(scratch("damaged.bcc4"), "rb");
  n = file ? fread(bytes, 1, sizeof bytes, file) : 0;
  if (file) fclose(file);
  EXPECT(n > damaged && n < sizeof bytes);
  bytes[damaged] ^= 1;
  OK(bccsplat_volume_open_memory(device, bytes, n, NULL, &volume));
  bccsplat_device_release(device); /* the volume keeps it */
  OK(bccsplat_volume_verify(volume, NULL, NULL, &report));
  EXPECT(report.damages > 0 && (uint64_t)lines == report.damages + 1); /* and what is left whole */
  EXPECT(report.first_damaged_offset <= damaged && report.bytes_checked > 0);
  bccsplat_volume_release(volume);
}

static void budget(void) {
  SIZED(bccsplat_device_options, o);
  SIZED(bccsplat_device_info, info);
  bccsplat_device* device = NULL;
  bccsplat_frame* frame = NULL;
  o.memory_budget = 100 * 100 * 16;
  OK(bccsplat_device_create(&o, &device));
  OK(bccsplat_frame_create(device, 100, 100, BCCSPLAT_FRAME_RGBA, &frame));
  OK(bccsplat_device_get_info(device, &info));
  EXPECT(info.memory_used == o.memory_budget && info.memory_budget == o.memory_budget);
  bccsplat_frame_release(frame);
  frame = (bccsplat_frame*)device;
  REFUSED(MEMORY_BUDGET, "160000", bccsplat_frame_create(device, 101, 100, BCCSPLAT_FRAME_RGBA, &frame));
  EXPECT(!frame);
  REFUSED(MEMORY_BUDGET, "raise the memory budget",
          bccsplat_frame_create(device, 65536, 65536, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_TIME, &frame));
  OK(bccsplat_device_get_info(device, &info));
  EXPECT(info.memory_used == 0 && info.memory_peak == o.memory_budget);
  bccsplat_device_release(device);
}

/* A file with more sites than the host allows is refused before anything is read of them. */
static void max_sites(void) {
  SIZED(bccsplat_device_options, o);
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  OK(bccsplat_device_create(NULL, &device));
  write_series(device, scratch("sites.bcc4"));
  bccsplat_device_release(device);
  o.max_sites = 100;
  OK(bccsplat_device_create(&o, &device));
  REFUSED(LIMIT_EXCEEDED, "100", bccsplat_volume_open_file(device, scratch("sites.bcc4"), NULL, &volume));
  EXPECT(!volume);
  bccsplat_device_release(device);
}

/* There is one, or the error says what is missing. */
static void gpu(void) {
  SIZED(bccsplat_gpu_info, info);
  bccsplat_device* device = NULL;
  bccsplat_status status;
  OK(bccsplat_device_create(NULL, &device));
  status = bccsplat_device_get_gpu_info(device, &info);
  if (status == BCCSPLAT_OK)
    EXPECT(info.renderer[0] && info.version[0] && info.memory_used == 0);
  else
    EXPECT(status == BCCSPLAT_ERROR_MISSING_FEATURE && strstr(bccsplat_last_error(), "gpu: "));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_device_get_gpu_info(NULL, &info));
  bccsplat_device_release(device);
}

void test_device(void) {
  gpu();
  SIZED(bccsplat_device_options, options);
  bccsplat_device* device = NULL;

  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_device_create(NULL, NULL));
  options.thread_count = -1;
  device = (bccsplat_device*)&options;
  REFUSED(INVALID_ARGUMENT, "thread_count", bccsplat_device_create(&options, &device));
  EXPECT(!device);
  options.thread_count = 5000;
  REFUSED(INVALID_ARGUMENT, "thread_count", bccsplat_device_create(&options, &device));
  options.thread_count = 2;
  INPUT_SIZES(bccsplat_device_options, options, bccsplat_device_create(in, &device),
              bccsplat_device_release(device));
  options.struct_size = 8; /* a header with a thread count and nothing else: what follows is not read */
  options.memory_budget = 1;
  OK(bccsplat_device_create(&options, &device));
  counts(device);
  bccsplat_device_release(device);

  OK(bccsplat_device_create(NULL, &device));
  counts(device);
  bccsplat_device_retain(device);
  bccsplat_device_release(device);
  counts(device); /* still there */
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_device_get_info(NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_device_get_info(device, NULL));
  OUTPUT_SIZES(bccsplat_device_info, bccsplat_device_get_info(device, out), (void)0);
  bccsplat_device_release(device);
  bccsplat_device_retain(NULL);
  bccsplat_device_release(NULL);

  threads_and_runners();
  runners_that_leave_bodies_out();
  log_of_damage();
  budget();
  max_sites();
}
