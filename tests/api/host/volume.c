/* SPDX-License-Identifier: Apache-2.0 */
/* Volume: opened from a file, memory and a stream; asked about everything, rightly and wrongly. */
#include "host.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

/* A .bcc4 inside a host's archive: other bytes stand before and behind it. */
enum { BEFORE = 77 };
static unsigned char archive[64 * 1024];
static uint64_t file_size;
enum fault { NONE, FAILS, SHORT, TOO_LONG };
static int64_t read_archive(void* user, uint64_t offset, void* buffer, uint64_t size) {
  switch (*(enum fault*)user) {
  case FAILS:
    return -1;
  case SHORT:
    return (int64_t)size - 1;
  case TOO_LONG:
    return (int64_t)size + 1;
  default:
    EXPECT(offset + size <= file_size);
    memcpy(buffer, archive + BEFORE + offset, size);
    return (int64_t)size;
  }
}

static void streams(bccsplat_device* device, const bccsplat_volume* same) {
  enum fault fault = NONE;
  SIZED(bccsplat_read_stream, stream);
  bccsplat_volume* volume = NULL;
  const double at[4] = {5.5, 6, 5, 1.5};
  float a = 0, b = 1;
  REFUSED(INVALID_ARGUMENT, "stream is NULL", bccsplat_volume_open_stream(device, NULL, NULL, &volume));
  REFUSED(INVALID_ARGUMENT, "read_at", bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  stream.read_at = read_archive;
  stream.user = &fault;
  stream.size = file_size;
  stream.reserved = 1;
  REFUSED(INVALID_ARGUMENT, "reserved", bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  stream.reserved = 0;
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_volume_open_stream(NULL, &stream, NULL, &volume));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_open_stream(device, &stream, NULL, NULL));
  INPUT_SIZES(bccsplat_read_stream, stream, bccsplat_volume_open_stream(device, in, NULL, &volume),
              bccsplat_volume_release(volume));
  fault = FAILS;
  REFUSED(IO, "host could not read", bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  EXPECT(!volume);
  fault = SHORT;
  REFUSED(TRUNCATED, "stream", bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  fault = TOO_LONG;
  REFUSED(IO, "", bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  fault = NONE;
  OK(bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  OK(bccsplat_volume_evaluate(volume, 1, at, &a, NULL));
  OK(bccsplat_volume_evaluate(same, 1, at, &b, NULL));
  EXPECT(a == b);
  bccsplat_volume_release(volume);
  OK(bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  fault = FAILS; /* later, when a chunk is wanted */
  REFUSED(IO, "host could not read", bccsplat_volume_evaluate(volume, 1, at, &a, NULL));
  fault = NONE; /* and the volume is as good as before */
  OK(bccsplat_volume_evaluate(volume, 1, at, &a, NULL));
  EXPECT(a == b);
  bccsplat_volume_release(volume);
}

static void damaged_files(bccsplat_device* device) {
  bccsplat_volume* volume = NULL;
  unsigned char* copy = malloc(file_size);
  REFUSED(INVALID_ARGUMENT, "bytes is NULL", bccsplat_volume_open_memory(device, NULL, 10, NULL, &volume));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_volume_open_memory(NULL, copy, 10, NULL, &volume));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_open_memory(device, copy, 10, NULL, NULL));
  memcpy(copy, archive + BEFORE, file_size);
  OK(bccsplat_volume_open_memory(device, copy, file_size, NULL, &volume));
  bccsplat_volume_release(volume);
  REFUSED(TRUNCATED, "", bccsplat_volume_open_memory(device, copy, file_size / 2, NULL, &volume));
  EXPECT(!volume);
  memset(copy, 'x', file_size);
  REFUSED(NOT_BCC4, "", bccsplat_volume_open_memory(device, copy, file_size, NULL, &volume));
  free(copy);
}

static int32_t cancel_at_once(void* user, double fraction) {
  ++*(int*)user;
  EXPECT(fraction >= 0 && fraction <= 1);
  return 1;
}

/* As many pairs as there are frames, of what was written. */
/* An evenly spaced volume has no coordinates, and its affine takes indices to the world. */
static void axes(const bccsplat_volume* volume) {
  bccsplat_axis axis = BCCSPLAT_INIT(bccsplat_axis);
  bccsplat_volume_info info = BCCSPLAT_INIT(bccsplat_volume_info);
  const double index[3] = {1, 2.5, 3};
  double world[3] = {0}, back[3] = {0}, expected;
  int r, c;
  OK(bccsplat_volume_get_axis(volume, 2, &axis));
  EXPECT(axis.count == 0 && axis.coordinates == NULL && axis.unit[0] == 0);
  REFUSED(NOT_FOUND, "axis 3", bccsplat_volume_get_axis(volume, 3, &axis));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_volume_get_axis(volume, 0, NULL));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_axis(NULL, 0, &axis));

  OK(bccsplat_volume_get_info(volume, &info));
  OK(bccsplat_volume_index_to_world(volume, 1, index, world));
  for (r = 0; r < 3; ++r) {
    expected = info.affine[4 * r + 3];
    for (c = 0; c < 3; ++c) expected += info.affine[4 * r + c] * index[c];
    EXPECT(fabs(world[r] - expected) < 1e-9);
  }
  OK(bccsplat_volume_world_to_index(volume, 1, world, back));
  for (c = 0; c < 3; ++c) EXPECT(fabs(back[c] - index[c]) < 1e-9);
  OK(bccsplat_volume_index_to_world(volume, 0, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "from is NULL", bccsplat_volume_index_to_world(volume, 1, NULL, world));
  REFUSED(INVALID_ARGUMENT, "to is NULL", bccsplat_volume_world_to_index(volume, 1, world, NULL));
}

static void frame_ranges(const bccsplat_volume* volume) {
  double ranges[2 * NT + 2] = {0};
  static float samples[SAMPLES];
  uint64_t count = 0;
  int t, i;
  OK(bccsplat_volume_get_frame_ranges(volume, 0, NULL, 0, &count));
  EXPECT(count == NT);
  ranges[4] = -1;
  OK(bccsplat_volume_get_frame_ranges(volume, 0, ranges, 2, NULL));
  EXPECT(ranges[3] > 0 && ranges[4] == -1);
  OK(bccsplat_volume_get_frame_ranges(volume, 0, ranges, NT + 1, &count));
  for (t = 0; t < NT; ++t) {
    float low = 1e9f, high = -1e9f;
    fill_frame(samples, t);
    for (i = 0; i < SAMPLES; ++i)
      low = samples[i] < low ? samples[i] : low, high = samples[i] > high ? samples[i] : high;
    EXPECT(ranges[2 * t] == low && ranges[2 * t + 1] == high);
  }
  EXPECT(ranges[2 * NT] == 0);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_frame_ranges(NULL, 0, ranges, 1, &count));
  REFUSED(INVALID_ARGUMENT, "ranges is NULL", bccsplat_volume_get_frame_ranges(volume, 0, NULL, 1, &count));
  REFUSED(NOT_FOUND, "channel 1", bccsplat_volume_get_frame_ranges(volume, 1, ranges, 1, &count));
}

static void facts(bccsplat_device* device, bccsplat_volume* volume) {
  SIZED(bccsplat_volume_info, info);
  SIZED(bccsplat_channel_info, channel_info);
  SIZED(bccsplat_level_info, level_info);
  SIZED(bccsplat_verify_report, report);
  SIZED(bccsplat_look, look);
  double times[NT + 1] = {0}, number = -1;
  const char *key = "unset", *value = "unset";
  uint64_t count = 0, bytes = 0;
  uint32_t channel = 99, crc = 0;
  int calls = 0, axis = 0;
  (void)device;
  OK(bccsplat_volume_get_info(volume, &info));
  EXPECT(info.dims[0] == NX && info.dims[3] == NT && info.channel_count == 1 && info.attribute_count >= 1);
  EXPECT(info.time_first == 10 && info.time_last == 10 + 2 * (NT - 1) && info.time_uniform == 1);
  EXPECT(strcmp(info.spatial_unit, "") == 0 && info.affine[0] == 1 && info.affine[15] == 1);
  EXPECT(info.bytes_file == file_size && info.has_holes == 0);
  for (axis = 0; axis < 4; ++axis) EXPECT(info.scales[axis] > 0.8 && info.scales[axis] < 1 + 1e-12);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_info(NULL, &info));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_volume_get_info(volume, NULL));
  OUTPUT_SIZES(bccsplat_volume_info, bccsplat_volume_get_info(volume, out), (void)0);

  OK(bccsplat_volume_get_level_info(volume, 0, &level_info));
  EXPECT(info.level_count == 0 && level_info.sites_total == info.sites_total);
  EXPECT(level_info.slab_layers >= 4 && level_info.slab_layers <= 32);
  EXPECT(level_info.layer_count == info.layer_count && level_info.scales[2] == info.scales[2]);
  EXPECT(level_info.bytes >= info.bytes_values + info.bytes_runs && level_info.bytes < file_size);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_level_info(NULL, 0, &level_info));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_volume_get_level_info(volume, 0, NULL));
  REFUSED(NOT_FOUND, "level 1", bccsplat_volume_get_level_info(volume, 1, &level_info));
  OUTPUT_SIZES(bccsplat_level_info, bccsplat_volume_get_level_info(volume, 0, out), (void)0);

  OK(bccsplat_volume_get_look(volume, 0, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_DEFAULT, &look));
  EXPECT(look.color_count >= 1 && look.opacity_count >= 1 && look.range[0] <= look.range[1]);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_look(NULL, 0, 0, 0, &look));
  REFUSED(INVALID_ARGUMENT, "out is NULL", bccsplat_volume_get_look(volume, 0, 0, 0, NULL));
  REFUSED(INVALID_ARGUMENT, "look is 8", bccsplat_volume_get_look(volume, 0, 8, 0, &look));
  REFUSED(INVALID_ARGUMENT, "mode is 5", bccsplat_volume_get_look(volume, 0, 0, 5, &look));
  REFUSED(NOT_FOUND, "channel 1", bccsplat_volume_get_look(volume, 1, 0, 0, &look));
  OUTPUT_SIZES(bccsplat_look, bccsplat_volume_get_look(volume, 0, 0, 0, out), (void)0);

  OK(bccsplat_volume_get_channel_info(volume, 0, &channel_info));
  EXPECT(strcmp(channel_info.name, "value") == 0 && channel_info.value_type == BCCSPLAT_TYPE_F32);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_channel_info(NULL, 0, &channel_info));
  REFUSED(INVALID_ARGUMENT, "info is NULL", bccsplat_volume_get_channel_info(volume, 0, NULL));
  REFUSED(NOT_FOUND, "channel 1", bccsplat_volume_get_channel_info(volume, 1, &channel_info));
  OUTPUT_SIZES(bccsplat_channel_info, bccsplat_volume_get_channel_info(volume, 0, out), (void)0);

  OK(bccsplat_volume_find_channel(volume, "value", &channel));
  EXPECT(channel == 0);
  REFUSED(NOT_FOUND, "colour", bccsplat_volume_find_channel(volume, "colour", &channel));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_find_channel(NULL, "value", &channel));
  REFUSED(INVALID_ARGUMENT, "name is NULL", bccsplat_volume_find_channel(volume, NULL, &channel));
  REFUSED(INVALID_ARGUMENT, "channel is NULL", bccsplat_volume_find_channel(volume, "value", NULL));

  OK(bccsplat_volume_get_times(volume, NULL, 0, &count));
  EXPECT(count == NT);
  times[2] = -1;
  OK(bccsplat_volume_get_times(volume, times, 2, NULL));
  EXPECT(times[0] == 10 && times[1] == 12 && times[2] == -1);
  OK(bccsplat_volume_get_times(volume, times, NT + 1, &count));
  EXPECT(times[NT - 1] == 18 && times[NT] == 0);
  REFUSED(INVALID_ARGUMENT, "times is NULL", bccsplat_volume_get_times(volume, NULL, 1, &count));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_times(NULL, times, 1, &count));
  frame_ranges(volume);
  axes(volume);

  OK(bccsplat_volume_time_to_index(volume, 13, &number));
  EXPECT(number == 1.5);
  REFUSED(OUT_OF_DOMAIN, "18.5", bccsplat_volume_time_to_index(volume, 18.5, &number));
  REFUSED(OUT_OF_DOMAIN, "", bccsplat_volume_time_to_index(volume, NAN, &number));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_time_to_index(NULL, 13, &number));
  REFUSED(INVALID_ARGUMENT, "index is NULL", bccsplat_volume_time_to_index(volume, 13, NULL));
  EXPECT(number == 1.5); /* untouched by the failures */
  OK(bccsplat_volume_index_to_time(volume, 1.5, &number));
  EXPECT(number == 13);
  REFUSED(OUT_OF_DOMAIN, "", bccsplat_volume_index_to_time(volume, -0.5, &number));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_index_to_time(NULL, 0, &number));
  REFUSED(INVALID_ARGUMENT, "time is NULL", bccsplat_volume_index_to_time(volume, 0, NULL));

  OK(bccsplat_volume_get_attribute(volume, 0, &key, &value));
  EXPECT(key && *key && value);
  REFUSED(NOT_FOUND, "attribute", bccsplat_volume_get_attribute(volume, info.attribute_count, &key, &value));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_attribute(NULL, 0, &key, &value));
  REFUSED(INVALID_ARGUMENT, "key is NULL", bccsplat_volume_get_attribute(volume, 0, NULL, &value));
  REFUSED(INVALID_ARGUMENT, "value is NULL", bccsplat_volume_get_attribute(volume, 0, &key, NULL));
  OK(bccsplat_volume_get_source(volume, 0, &value, &bytes, &crc));
  EXPECT(strcmp(value, "simulation") == 0 && bytes == 1234 && crc == 0xabcdu);
  OK(bccsplat_volume_get_source(volume, 0, NULL, NULL, NULL));
  REFUSED(NOT_FOUND, "source 1 of 1", bccsplat_volume_get_source(volume, 1, &value, &bytes, &crc));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_source(NULL, 0, &value, &bytes, &crc));
  OK(bccsplat_volume_find_attribute(volume, "origin", &value));
  EXPECT(strcmp(value, "tests") == 0);
  REFUSED(NOT_FOUND, "colour", bccsplat_volume_find_attribute(volume, "colour", &value));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_find_attribute(NULL, "origin", &value));
  REFUSED(INVALID_ARGUMENT, "key is NULL", bccsplat_volume_find_attribute(volume, NULL, &value));
  REFUSED(INVALID_ARGUMENT, "value is NULL", bccsplat_volume_find_attribute(volume, "origin", NULL));

  OK(bccsplat_volume_verify(volume, NULL, NULL, &report));
  EXPECT(report.damages == 0 && report.chunks > 0 && report.bytes_checked > 0);
  EXPECT(report.unreadable == 0 && report.first_unreadable_offset == 0);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_verify(NULL, NULL, NULL, &report));
  REFUSED(INVALID_ARGUMENT, "report is NULL", bccsplat_volume_verify(volume, NULL, NULL, NULL));
  OUTPUT_SIZES(bccsplat_verify_report, bccsplat_volume_verify(volume, NULL, NULL, out), (void)0);
  EXPECT(bccsplat_volume_verify(volume, cancel_at_once, &calls, &report) == BCCSPLAT_CANCELLED);
  EXPECT(calls == 1 && strstr(bccsplat_last_error(), "cancel"));
}

static void evaluate(const bccsplat_volume* volume) {
  const double at[3][4] = {{5, 6, 5, 0}, {-1, 6, 5, 0}, {5.5, 6, 5, 1}};
  const double placed[3][4] = {{5, 6, 5, 10}, {-1, 6, 5, 10}, {5.5, 6, 5, 12}}; /* the same */
  const uint64_t begin[3] = {5, 6, 5}, end[3] = {6, 8, 6};
  float values[3] = {0}, gradients[3][4];
  uint64_t missing = 7;
  OK(bccsplat_volume_evaluate(volume, 0, NULL, NULL, NULL)); /* no points, no arrays */
  OK(bccsplat_volume_evaluate(volume, 1, at[0], values, gradients[0]));
  EXPECT(fabs(values[0] - 100) < 2 && fabs(gradients[0][1]) < 2);
  REFUSED(OUT_OF_DOMAIN, "1 of 3 points lie outside the domain; point 1 has the index -1 along x",
          bccsplat_volume_evaluate(volume, 3, at[0], values, NULL));
  EXPECT(isnan(values[1]) && fabs(values[2] - 100) < 2); /* the others are there */
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_evaluate(NULL, 1, at[0], values, NULL));
  REFUSED(INVALID_ARGUMENT, "xyzt is NULL", bccsplat_volume_evaluate(volume, 1, NULL, values, NULL));
  REFUSED(INVALID_ARGUMENT, "values is NULL", bccsplat_volume_evaluate(volume, 1, at[0], NULL, NULL));
  OK(bccsplat_volume_evaluate_channel(volume, 0, 1, at[2], values, NULL));
  REFUSED(NOT_FOUND, "channel 1", bccsplat_volume_evaluate_channel(volume, 1, 1, at[0], values, NULL));
  REFUSED(INVALID_ARGUMENT, "volume", bccsplat_volume_evaluate_channel(NULL, 0, 1, at[0], values, NULL));
  OK(bccsplat_volume_evaluate_world(volume, 0, 1, placed[2], &values[1], gradients[0], NULL));
  EXPECT(fabsf(values[1] - values[0]) < 1e-4f);
  REFUSED(NOT_FOUND, "channel 1",
          bccsplat_volume_evaluate_world(volume, 1, 1, placed[0], values, NULL, NULL));
  REFUSED(OUT_OF_DOMAIN, "point 1 has the index -1 along x",
          bccsplat_volume_evaluate_world(volume, 0, 3, placed[0], values, NULL, NULL));
  OK(bccsplat_volume_evaluate_world(volume, 0, 3, placed[0], values, NULL, &missing));
  EXPECT(missing == 1 && isnan(values[1]) && fabs(values[2] - 100) < 2);
  REFUSED(INVALID_ARGUMENT, "volume",
          bccsplat_volume_evaluate_world(NULL, 0, 1, placed[0], values, NULL, NULL));
  OK(bccsplat_volume_read_frame(volume, 0, 0, begin, end, values));
  EXPECT(fabs(values[0] - 100) < 2);
  REFUSED(OUT_OF_DOMAIN, "frame 1000 of", bccsplat_volume_read_frame(volume, 0, 1000, begin, end, values));
  REFUSED(INVALID_ARGUMENT, "no sample from 6 to before 5",
          bccsplat_volume_read_frame(volume, 0, 0, end, begin, values));
}

/* A finished file is what it was; it is still there under another name. */
static void reopen(const bccsplat_volume* volume) {
  SIZED(bccsplat_volume_info, info);
  SIZED(bccsplat_read_stream, stream);
  bccsplat_volume* newer = NULL;
  OK(bccsplat_volume_reopen(volume, NULL, &newer));
  OK(bccsplat_volume_get_info(newer, &info));
  EXPECT(info.dims[3] == NT && info.series_state == BCCSPLAT_SERIES_FINISHED);
  evaluate(newer);
  bccsplat_volume_release(newer);
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_reopen(NULL, NULL, &newer));
  EXPECT(!newer);
  REFUSED(INVALID_ARGUMENT, "newer is NULL", bccsplat_volume_reopen(volume, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "read_at", bccsplat_volume_reopen(volume, &stream, &newer));
}

void test_volume(void) {
  SIZED(bccsplat_volume_options, options);
  bccsplat_device* device = NULL;
  bccsplat_volume *volume = NULL, *other = NULL;
  FILE* file;

  OK(bccsplat_device_create(NULL, &device));
  volume = open_series(device, scratch("v.bcc4"));
  file = fopen(scratch("v.bcc4"), "rb");
  file_size = file ? fread(archive + BEFORE, 1, sizeof archive - BEFORE, file) : 0;
  if (file) fclose(file);
  EXPECT(file_size > 1000 && file_size < sizeof archive - BEFORE);

  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_volume_open_file(NULL, "x", NULL, &other));
  REFUSED(INVALID_ARGUMENT, "path is NULL", bccsplat_volume_open_file(device, NULL, NULL, &other));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_open_file(device, "x", NULL, NULL));
  other = volume;
  REFUSED(FILE_NOT_FOUND, "none.bcc4", bccsplat_volume_open_file(device, scratch("none.bcc4"), NULL, &other));
  EXPECT(!other);
  REFUSED(IO, "", bccsplat_volume_open_file(device, scratch(""), NULL, &other)); /* a folder */
  options.kernel = "radail20+b3";
  REFUSED(NOT_FOUND, "radial20", bccsplat_volume_open_file(device, scratch("v.bcc4"), &options, &other));
  options.kernel = "fast";
  INPUT_SIZES(bccsplat_volume_options, options,
              bccsplat_volume_open_file(device, scratch("v.bcc4"), in, &other),
              bccsplat_volume_release(other));
  facts(device, volume);
  evaluate(volume);
  streams(device, volume);
  damaged_files(device);

  reopen(volume);

  bccsplat_device_release(device); /* the volume keeps it */
  bccsplat_volume_retain(volume);
  bccsplat_volume_release(volume);
  evaluate(volume);
  bccsplat_volume_release(volume);
  bccsplat_volume_retain(NULL);
  bccsplat_volume_release(NULL);
}
