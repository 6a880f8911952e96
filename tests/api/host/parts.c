/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a series: written apart, joined, and everything that does not fit together. */
#include "host.h"

#include <math.h>
#include <unistd.h>

static float samples[SAMPLES];
static double times[NT];

static bccsplat_writer_options part_options(bccsplat_series_part* part, uint64_t first, uint64_t end) {
  bccsplat_writer_options o = series_options();
  int t;
  for (t = 0; t < NT; ++t) times[t] = 10 + 2 * t;
  memset(part, 0, sizeof *part);
  part->struct_size = sizeof *part;
  part->first = first, part->end = end, part->times = times;
  o.part = part;
  o.time_scale = 0.3; /* several slabs of layers in five frames */
  return o;
}

/* Adds the frames that the writer asks for. */
static void feed(bccsplat_writer* writer) {
  const bccsplat_box box = frame_box(samples);
  uint64_t begin = 99, end = 99;
  uint64_t first[3], last[3];
  OK(bccsplat_writer_get_part_box(writer, first, last));
  EXPECT(first[0] == 0 && last[0] == (uint64_t)box.dims[0]);
  OK(bccsplat_writer_get_part_frames(writer, &begin, &end));
  EXPECT(begin < end && end <= NT);
  for (; begin < end; ++begin) {
    fill_frame(samples, (double)begin);
    OK(bccsplat_writer_add_frame(writer, 0, 10 + 2 * (double)begin, &box, 1));
  }
}

/* Paths that stay valid. */
static const char* path_of(int file) {
  static char paths[4][4096];
  static const char* const names[] = {"whole.bcc4", "a.bcc4", "b.bcc4", "joined.bcc4"};
  strcpy(paths[file], scratch(names[file]));
  return paths[file];
}

static const char* write_part(bccsplat_device* device, int file, bccsplat_writer_options options) {
  bccsplat_writer* writer = NULL;
  OK(bccsplat_writer_create(device, path_of(file), &options, &writer));
  feed(writer);
  OK(bccsplat_writer_finish(writer, NULL));
  bccsplat_writer_release(writer);
  return path_of(file);
}

static int equal_files(const char* a, const char* b) {
  FILE *x = fopen(a, "rb"), *y = fopen(b, "rb");
  int same = x && y, c = 0;
  while (same && c != EOF) {
    c = fgetc(x);
    same = c == fgetc(y);
  }
  if (x) fclose(x);
  if (y) fclose(y);
  return same;
}

static void wrong_options(bccsplat_device* device) {
  bccsplat_writer* writer = NULL;
#define WRONG(word, ...)                                                                                     \
  do {                                                                                                       \
    bccsplat_series_part part;                                                                               \
    bccsplat_writer_options o = part_options(&part, 1, 3);                                                   \
    __VA_ARGS__;                                                                                             \
    REFUSED(INVALID_ARGUMENT, word, bccsplat_writer_create(device, scratch("wrong.bcc4"), &o, &writer));     \
    EXPECT(!writer);                                                                                         \
  } while (0)
  WRONG("reserved", part.reserved = 1);
  WRONG("at least one", part.end = 1);
  WRONG("the series has 5", part.end = 6);
  WRONG("part.times is NULL", part.times = NULL);
  WRONG("does not rise", times[3] = times[2]);
  WRONG("part.times", times[0] = NAN);
  WRONG("lead", part.lead = 2);
  WRONG("dims[3]", o.dims[3] = 0);
  WRONG("the range of the series", o.nonfinite = BCCSPLAT_NONFINITE_CLAMP);
#undef WRONG
}

void test_parts(void) {
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  bccsplat_writer* writer = NULL;
  bccsplat_series_part part;
  bccsplat_writer_options options;
  SIZED(bccsplat_join_options, join);
  SIZED(bccsplat_writer_report, report);
  SIZED(bccsplat_volume_info, info);
  const char *two[2], *one, *whole, *joined;
  uint64_t begin, end;
  OK(bccsplat_device_create(NULL, &device));
  wrong_options(device);

  options = part_options(&part, 0, 5);
  options.part = NULL;
  whole = write_part(device, 0, options);
  two[1] = write_part(device, 1, part_options(&part, 0, 2));
  two[0] = write_part(device, 2, part_options(&part, 2, 5));
  joined = path_of(3);
  join.overwrite = 1;
  OK(bccsplat_join_parts(device, 2, two, joined, &join, &report));
  EXPECT(equal_files(whole, joined));
  EXPECT(report.frames == NT && report.cc_samples == NT * SAMPLES && report.slabs_reused > 1);
  INPUT_SIZES(bccsplat_join_options, join, bccsplat_join_parts(device, 2, two, joined, in, NULL), (void)0);
  OUTPUT_SIZES(bccsplat_writer_report, bccsplat_join_parts(device, 2, two, joined, &join, out), (void)0);
  REFUSED(FILE_EXISTS, "joined.bcc4", bccsplat_join_parts(device, 2, two, joined, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_join_parts(NULL, 2, two, joined, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "parts is NULL", bccsplat_join_parts(device, 2, NULL, joined, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "path is NULL", bccsplat_join_parts(device, 2, two, NULL, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "no parts", bccsplat_join_parts(device, 0, two, joined, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "frames 0 to 1 of 5", bccsplat_join_parts(device, 1, two, joined, &join, NULL));
  join.reserved = 1;
  REFUSED(INVALID_ARGUMENT, "reserved", bccsplat_join_parts(device, 2, two, joined, &join, NULL));
  join.reserved = 0;
  EXPECT(equal_files(whole, joined)); /* as it was */

  OK(bccsplat_volume_open_file(device, two[0], NULL, &volume));
  OK(bccsplat_volume_get_info(volume, &info));
  EXPECT(info.part_first == 2 && info.part_end == 5 && info.dims[3] == NT);
  bccsplat_volume_release(volume);
  OK(bccsplat_volume_open_file(device, joined, NULL, &volume));
  OK(bccsplat_volume_get_info(volume, &info));
  EXPECT(info.part_first == 0 && info.part_end == 0);
  bccsplat_volume_release(volume);

  /* What is asked of the series shows when it is there. */
  options = part_options(&part, 0, 5);
  options.psnr = 300;
  one = write_part(device, 1, options);
  REFUSED(BOUND_NOT_MET, "300 asked for", bccsplat_join_parts(device, 1, &one, joined, &join, NULL));

  options = part_options(&part, 3, 4);
  OK(bccsplat_writer_create(device, scratch("a.bcc4"), &options, &writer));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_get_part_frames(NULL, &begin, &end));
  REFUSED(INVALID_ARGUMENT, "begin is NULL", bccsplat_writer_get_part_frames(writer, NULL, &end));
  REFUSED(INVALID_ARGUMENT, "end is NULL", bccsplat_writer_get_part_frames(writer, &begin, NULL));
  uint64_t low[3], high[3];
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_get_part_box(NULL, low, high));
  REFUSED(INVALID_ARGUMENT, "begin is NULL", bccsplat_writer_get_part_box(writer, NULL, high));
  REFUSED(INVALID_ARGUMENT, "end is NULL", bccsplat_writer_get_part_box(writer, low, NULL));
  OK(bccsplat_writer_get_part_box(writer, low, high));
  REFUSED(UNSUPPORTED, "made of frames", bccsplat_writer_add_layer(writer, 0, 0, samples, SAMPLES));
  bccsplat_writer_release(writer);
  OK(bccsplat_writer_create(device, scratch("a.bcc4"), &options, &writer));
  REFUSED(INVALID_ARGUMENT, "of the part's times", bccsplat_writer_add_frame(writer, 0, 11, NULL, 0));
  bccsplat_writer_release(writer);
  unlink(joined);
  bccsplat_device_release(device);
}
