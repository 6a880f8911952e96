/* SPDX-License-Identifier: Apache-2.0 */
/* The library leaves its host's process alone: no output, no locale, no floating-point mode, UTF-8 paths. */
#include "host.h"

#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <stdlib.h>
#include <unistd.h>

/* Everything once: a file, a slice, a picture, a failure. */
static void use_everything(const char* path, const char* picture) {
  SIZED(bccsplat_image_options, overwrite);
  bccsplat_device* device = NULL;
  bccsplat_volume *volume, *none;
  bccsplat_slice* slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  const bccsplat_hyperplane plane = at_frame(1.25);
  OK(bccsplat_device_create(NULL, &device));
  volume = open_series(device, path);
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_renderer_create(device, &renderer));
  OK(bccsplat_renderer_set_slice(renderer, slice));
  OK(bccsplat_frame_create(device, 32, 32, BCCSPLAT_FRAME_RGBA, &frame));
  OK(bccsplat_renderer_render(renderer, frame));
  overwrite.overwrite = 1;
  if (!strstr(bccsplat_build_info(), "image=none")) {
    OK(bccsplat_frame_save_png(frame, picture, &overwrite));
    OK(bccsplat_frame_save_exr(frame, picture, &overwrite));
  }
  EXPECT(bccsplat_volume_open_file(device, scratch("none"), NULL, &none) != BCCSPLAT_OK);
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
}

static long size_of(const char* path) {
  FILE* file = fopen(path, "rb");
  long size;
  if (!file) return -1;
  fseek(file, 0, SEEK_END);
  size = ftell(file);
  fclose(file);
  return size;
}

static void no_output(void) {
  const int out = dup(1), error = dup(2), sink = open(scratch("printed"), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  fflush(stdout);
  EXPECT(sink >= 0 && dup2(sink, 1) >= 0 && dup2(sink, 2) >= 0);
  use_everything(scratch("quiet.bcc4"), scratch("quiet.image"));
  fflush(stdout);
  dup2(out, 1);
  dup2(error, 2);
  close(sink);
  EXPECT(size_of(scratch("printed")) == 0);
}

static int same_file(const char* a, const char* b) {
  static unsigned char bytes[2][64 * 1024];
  size_t n[2], i;
  for (i = 0; i < 2; ++i) {
    FILE* file = fopen(i ? b : a, "rb");
    n[i] = file ? fread(bytes[i], 1, sizeof bytes[i], file) : 0;
    if (file) fclose(file);
  }
  return n[0] > 500 && n[0] < sizeof bytes[0] && n[0] == n[1] && memcmp(bytes[0], bytes[1], n[0]) == 0;
}

/* The same bytes and texts whatever the host's locale writes for a decimal point. */
static void locales(void) {
  static const char* const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "bccsplat_comma", "German"};
  bccsplat_device* device = NULL;
  bccsplat_volume* volume;
  double index;
  const char* found = NULL;
  size_t i;
  use_everything(scratch("plain.bcc4"), scratch("plain.image"));
  for (i = 0; i < sizeof names / sizeof *names && !found; ++i) found = setlocale(LC_ALL, names[i]);
  if (!found) {
    puts("no locale with a decimal comma here");
    return;
  }
  EXPECT(strcmp(localeconv()->decimal_point, ",") == 0);
  use_everything(scratch("comma.bcc4"), scratch("comma.image"));
  OK(bccsplat_device_create(NULL, &device));
  volume = open_series(device, scratch("comma.bcc4"));
  REFUSED(OUT_OF_DOMAIN, "18.5", bccsplat_volume_time_to_index(volume, 18.5, &index));
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
  EXPECT(strcmp(localeconv()->decimal_point, ",") == 0); /* still the host's choice */
  setlocale(LC_ALL, "C");
  EXPECT(same_file(scratch("plain.bcc4"), scratch("comma.bcc4")));
  EXPECT(strstr(bccsplat_build_info(), "image=none") ||
         same_file(scratch("plain.image"), scratch("comma.image")));
}

/* The host's rounding mode survives, and its traps never go off: the library computes with quiet NaNs. */
static void floating_point_mode(void) {
  EXPECT(fesetround(FE_UPWARD) == 0);
  use_everything(scratch("fp.bcc4"), scratch("fp.image"));
  EXPECT(fegetround() == FE_UPWARD);
  EXPECT(fesetround(FE_TONEAREST) == 0);
#if defined(__x86_64__)
  {
    const unsigned int flags = 0x3f; /* sticky exception flags may change, nothing else */
    unsigned int before, after;
    __asm__ volatile("stmxcsr %0" : "=m"(before));
    use_everything(scratch("fp.bcc4"), scratch("fp.image"));
    __asm__ volatile("stmxcsr %0" : "=m"(after));
    EXPECT((before & ~flags) == (after & ~flags));
  }
#endif
}

static void utf8_paths(void) {
  use_everything(scratch("Wei\xc3\x9f \xe6\xb0\xb4 \xf0\x9f\x92\xa8.bcc4"), scratch("\xc3\xbc.image"));
#if !defined(_WIN32) /* where fopen takes no UTF-8 */
  EXPECT(size_of(scratch("Wei\xc3\x9f \xe6\xb0\xb4 \xf0\x9f\x92\xa8.bcc4")) > 1000);
#endif
}

void test_hygiene(void) {
  no_output();
  locales();
  floating_point_mode();
  utf8_paths();
}
