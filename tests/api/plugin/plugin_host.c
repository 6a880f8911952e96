/* SPDX-License-Identifier: Apache-2.0 */
/* plugin_host LIBRARY SCRATCH: a host that knows the library by dlopen only, as a plugin's host does. Loads
 * and unloads it a hundred times, and two copies of it at once. */
#include <bccsplat.h>

#include "counted_heap.h"

#include <dirent.h>
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* clang-format off */
#define CALLS(CALL) \
  CALL(last_error) CALL(device_create) CALL(device_release) CALL(writer_create) CALL(writer_add_frame) \
  CALL(writer_finish) CALL(writer_release) CALL(volume_open_file) CALL(volume_release) CALL(slice_create) \
  CALL(slice_release) CALL(renderer_create) CALL(renderer_set_slice) CALL(renderer_render) \
  CALL(renderer_release) CALL(frame_wrap) CALL(frame_save_exr) CALL(frame_save_png) CALL(frame_release) \
  CALL(build_info)
/* clang-format on */

typedef struct library {
  void* handle;
  const char* path;
#define DECLARE(name) __typeof__(&bccsplat_##name) name;
  CALLS(DECLARE)
#undef DECLARE
} library;

static int failures = 0;
#define EXPECT(condition)                                                                                    \
  do {                                                                                                       \
    if (!(condition)) fprintf(stderr, "line %d: not so: %s\n", __LINE__, #condition), ++failures;            \
  } while (0)

static library load(const char* path) {
  library l = {.path = path, .handle = dlopen(path, RTLD_NOW | RTLD_LOCAL)};
  if (!l.handle) {
    fprintf(stderr, "%s\n", dlerror());
    exit(1);
  }
#define FIND(name) *(void**)(&l.name) = dlsym(l.handle, "bccsplat_" #name);
  CALLS(FIND)
#undef FIND
  return l;
}

static int count(const char* folder) {
  DIR* entries = opendir(folder);
  int n = 0;
  while (entries && readdir(entries)) ++n;
  if (entries) closedir(entries);
  return n - 2;
}
static int threads(void) { return count("/proc/self/task"); }
static int files(void) { return count("/proc/self/fd"); }

static int mapped(const char* path) {
  char line[4096];
  FILE* maps = fopen("/proc/self/maps", "r");
  int found = 0;
  while (maps && fgets(line, sizeof line, maps)) found |= strstr(line, path) != NULL;
  if (maps) fclose(maps);
  return found;
}

enum { N = 16, WIDTH = 40, HEIGHT = 30 };
typedef struct picture {
  float rgba[HEIGHT][WIDTH][4];
} picture;

static float samples[N * N * N];

/* A series, a slice of it and a picture, with the device's own threads; and one failure. */
static void use(const library* l, const char* path, picture* out) {
  bccsplat_device_options two = {.struct_size = sizeof two, .thread_count = 2};
  bccsplat_writer_options options = {.struct_size = sizeof options, .dims = {N, N, N, 3}, .overwrite = 1};
  bccsplat_box box = {
      .struct_size = sizeof box, .type = BCCSPLAT_TYPE_F32, .data = samples, .dims = {N, N, N}};
  bccsplat_hyperplane plane = {.struct_size = sizeof plane, .d = 1, .e = -1.5};
  bccsplat_image_options overwrite = {.struct_size = sizeof overwrite, .overwrite = 1};
  bccsplat_device* device = NULL;
  bccsplat_writer* writer = NULL;
  bccsplat_volume* volume = NULL;
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  char image[4200];
  int i;
  EXPECT(l->device_create(&two, &device) == BCCSPLAT_OK);
  EXPECT(l->writer_create(device, path, &options, &writer) == BCCSPLAT_OK);
  for (i = 0; i < 3; ++i) EXPECT(l->writer_add_frame(writer, 0, i, &box, 1) == BCCSPLAT_OK);
  EXPECT(l->writer_finish(writer, NULL) == BCCSPLAT_OK);
  EXPECT(l->volume_open_file(device, path, NULL, &volume) == BCCSPLAT_OK);
  EXPECT(l->slice_create(volume, &plane, NULL, &slice) == BCCSPLAT_OK);
  EXPECT(l->renderer_create(device, &renderer) == BCCSPLAT_OK);
  EXPECT(l->renderer_set_slice(renderer, slice) == BCCSPLAT_OK);
  EXPECT(l->frame_wrap(device, WIDTH, HEIGHT, &out->rgba[0][0][0], 0, &frame) == BCCSPLAT_OK);
  EXPECT(l->renderer_render(renderer, frame) == BCCSPLAT_OK);
  if (!strstr(l->build_info(), "image=none")) {
    snprintf(image, sizeof image, "%s.exr", path);
    EXPECT(l->frame_save_exr(frame, image, &overwrite) == BCCSPLAT_OK);
    snprintf(image, sizeof image, "%s.png", path);
    EXPECT(l->frame_save_png(frame, image, &overwrite) == BCCSPLAT_OK);
  }
  EXPECT(l->slice_create(NULL, NULL, NULL, NULL) == BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT(strcmp(l->last_error(), "slice is NULL") == 0);
  l->frame_release(frame);
  l->renderer_release(renderer);
  l->slice_release(slice);
  l->volume_release(volume);
  l->writer_release(writer);
  l->device_release(device);
}

static void a_hundred_times(const char* path, const char* series) {
  static picture first, again;
  long blocks_before = 0;
  int threads_before = 0, files_before = 0, i;
  for (i = 0; i < 100; ++i) {
    library l = load(path);
    use(&l, series, i == 0 ? &first : &again);
    EXPECT(dlclose(l.handle) == 0);
    EXPECT(!mapped(path)); /* really gone */
    if (i > 0) EXPECT(memcmp(&first, &again, sizeof first) == 0);
    if (i == 4) { /* the loader and the C library have their own caches by now */
      blocks_before = heap_blocks();
      threads_before = threads();
      files_before = files();
      EXPECT(threads_before == 1);
    }
  }
  EXPECT(threads() == threads_before);
  EXPECT(files() == files_before);
  EXPECT(heap_blocks() <= blocks_before + 2); /* the loader's */
}

typedef struct job {
  library* loaded;
  char series[4200];
  picture picture;
} job;
static void* run_job(void* argument) {
  job* j = argument;
  use(j->loaded, j->series, &j->picture);
  return NULL;
}

/* Two copies at work in two threads: each has its own state, both draw the same. */
static void two_copies(const char* path, const char* copy, const char* series) {
  static job jobs[2];
  library libraries[2] = {load(path), load(copy)};
  pthread_t at_work[2];
  int i;
  EXPECT(libraries[0].device_create != libraries[1].device_create);
  for (i = 0; i < 2; ++i) {
    jobs[i].loaded = &libraries[i];
    snprintf(jobs[i].series, sizeof jobs[i].series, "%s%d", series, i);
    EXPECT(pthread_create(&at_work[i], NULL, run_job, &jobs[i]) == 0);
  }
  for (i = 0; i < 2; ++i) pthread_join(at_work[i], NULL);
  EXPECT(memcmp(&jobs[0].picture, &jobs[1].picture, sizeof(picture)) == 0);
  EXPECT(libraries[0].device_create(NULL, NULL) == BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT(strcmp(libraries[0].last_error(), "device is NULL") == 0);
  EXPECT(strcmp(libraries[1].last_error(), "") == 0); /* not the other's text */
  dlclose(libraries[0].handle);
  use(&libraries[1], series, &jobs[0].picture); /* and the one does without the other */
  dlclose(libraries[1].handle);
  EXPECT(!mapped(path) && !mapped(copy) && threads() == 1);
}

static void copy_file(const char* from, const char* to) {
  static char bytes[1 << 16];
  FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
  size_t n;
  EXPECT(in && out);
  while (in && out && (n = fread(bytes, 1, sizeof bytes, in)) > 0) EXPECT(fwrite(bytes, 1, n, out) == n);
  if (in) fclose(in);
  if (out) fclose(out);
}

int main(int argc, char** argv) {
  char series[4096], copy[4096];
  int i;
  if (argc != 3) return 2;
  for (i = 0; i < N * N * N; ++i) samples[i] = (float)exp(-pow(i % N - 8, 2) / 9 - pow(i / N % N - 8, 2) / 9);
  snprintf(series, sizeof series, "%s/plugin.bcc4", argv[2]);
  snprintf(copy, sizeof copy, "%s/copy.so", argv[2]);
  copy_file(argv[1], copy);
  a_hundred_times(argv[1], series);
  two_copies(argv[1], copy, series);
  return failures ? 1 : 0;
}
