/* SPDX-License-Identifier: Apache-2.0 */
/* host SCRATCH NAME: one of the tests below; 0 when everything held. */
#include "host.h"

#include <math.h>
#include <stdlib.h>
#if defined(_WIN32)
#include <windows.h>

#include <tlhelp32.h>
#else
#include <dirent.h>
#endif

int failures = 0;
static const char* folder = ".";

void expect_ok(bccsplat_status got, const char* call, const char* file, int line) {
  if (got == BCCSPLAT_OK) return;
  fprintf(stderr, "%s:%d: %s: %s (%s)\n", file, line, call, bccsplat_status_name(got), bccsplat_last_error());
  ++failures;
}

void expect_refused(bccsplat_status wanted, const char* word, bccsplat_status got, const char* call,
                    const char* file, int line) {
  if (got == wanted && strstr(bccsplat_last_error(), word)) return;
  fprintf(stderr, "%s:%d: %s: %s, \"%s\"; wanted %s with \"%s\"\n", file, line, call,
          bccsplat_status_name(got), bccsplat_last_error(), bccsplat_status_name(wanted), word);
  ++failures;
}

int untouched(const void* bytes, size_t begin, size_t end) {
  size_t i;
  for (i = begin; i < end; ++i)
    if (((const unsigned char*)bytes)[i] != 0xAB) return 0;
  return 1;
}

void fill_frame(float* samples, double frame) {
  int x, y, z;
  for (z = 0; z < NZ; ++z)
    for (y = 0; y < NY; ++y)
      for (x = 0; x < NX; ++x) {
        const double dx = x - 5 - 0.5 * frame, dy = y - 6, dz = z - 5;
        *samples++ = (float)(100 * exp(-(dx * dx + dy * dy + dz * dz) / 8));
      }
}

bccsplat_box frame_box(const float* samples) {
  SIZED(bccsplat_box, box);
  box.type = BCCSPLAT_TYPE_F32;
  box.data = samples;
  box.dims[0] = NX, box.dims[1] = NY, box.dims[2] = NZ;
  return box;
}

bccsplat_writer_options series_options(void) {
  SIZED(bccsplat_writer_options, o);
  o.dims[0] = NX, o.dims[1] = NY, o.dims[2] = NZ, o.dims[3] = NT;
  o.overwrite = 1;
  return o;
}

void write_series(bccsplat_device* device, const char* path) {
  const bccsplat_writer_options options = series_options();
  static float samples[SAMPLES];
  const bccsplat_box box = frame_box(samples);
  bccsplat_writer* writer = NULL;
  int t;
  OK(bccsplat_writer_create(device, path, &options, &writer));
  OK(bccsplat_writer_set_attribute(writer, "origin", "tests"));
  OK(bccsplat_writer_add_source(writer, "simulation", 1234, 0xabcd));
  for (t = 0; t < NT; ++t) {
    fill_frame(samples, t);
    OK(bccsplat_writer_add_frame(writer, 0, 10 + 2 * t, &box, 1));
  }
  OK(bccsplat_writer_finish(writer, NULL));
  bccsplat_writer_release(writer);
}

bccsplat_volume* open_series(bccsplat_device* device, const char* path) {
  bccsplat_volume* volume = NULL;
  write_series(device, path);
  OK(bccsplat_volume_open_file(device, path, NULL, &volume));
  return volume;
}

bccsplat_hyperplane at_frame(double frame) {
  SIZED(bccsplat_hyperplane, plane);
  plane.d = 1;
  plane.e = -frame;
  return plane;
}

const char* scratch(const char* name) {
  static char paths[4][4096];
  static int next = 0;
  char* path = paths[next = (next + 1) % 4];
  snprintf(path, sizeof paths[0], "%s/%s", folder, name);
  return path;
}

#if defined(_WIN32)
int thread_count(void) {
  HANDLE all = CreateToolhelp32Snapshot(TH32CS_SNAPTHREAD, 0);
  THREADENTRY32 thread;
  int n = 0, more;
  thread.dwSize = sizeof thread;
  for (more = Thread32First(all, &thread); more; more = Thread32Next(all, &thread))
    if (thread.th32OwnerProcessID == GetCurrentProcessId()) ++n;
  CloseHandle(all);
  return n;
}
#else
int thread_count(void) {
  DIR* tasks = opendir("/proc/self/task");
  int n = 0;
  while (tasks && readdir(tasks)) ++n;
  if (tasks) closedir(tasks);
  return n - 2; /* . and .. */
}
#endif

int main(int argc, char** argv) {
  static const struct {
    const char* name;
    void (*run)(void);
  } tests[] = {{"library", test_library}, {"device", test_device},     {"writer", test_writer},
               {"parts", test_parts},     {"volume", test_volume},     {"slice", test_slice},
               {"bricks", test_bricks},   {"renderer", test_renderer}, {"frame", test_frame},
               {"scene", test_scene},     {"plan", test_plan},         {"cancel_token", test_cancel_token},
               {"streams", test_streams}, {"hygiene", test_hygiene}};
  size_t i;
  if (argc != 3) {
    fprintf(stderr, "usage: host SCRATCH NAME\n");
    return 2;
  }
  folder = argv[1];
  for (i = 0; i < sizeof tests / sizeof *tests; ++i)
    if (strcmp(tests[i].name, argv[2]) == 0) {
      tests[i].run();
      return failures ? 1 : 0;
    }
  fprintf(stderr, "no test named %s\n", argv[2]);
  return 2;
}
