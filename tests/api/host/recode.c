/* SPDX-License-Identifier: Apache-2.0 */
/* A file written anew: what it may be asked for, and what comes out. */
#include "host.h"

#include <math.h>

static float samples[SAMPLES];

/* The series as bytes, so that what is stored are integers. */
static void write_bytes(bccsplat_device* device, const char* path) {
  bccsplat_writer_options options = series_options();
  bccsplat_writer* writer = NULL;
  static unsigned char bytes[SAMPLES];
  bccsplat_box box = frame_box(samples);
  int t, i;
  box.data = bytes, box.type = BCCSPLAT_TYPE_U8;
  for (i = 0; i < 3; ++i) box.stride_bytes[i] = 0;
  OK(bccsplat_writer_create(device, path, &options, &writer));
  for (t = 0; t < NT; ++t) {
    fill_frame(samples, t);
    for (i = 0; i < SAMPLES; ++i) bytes[i] = (unsigned char)samples[i];
    OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  }
  OK(bccsplat_writer_finish(writer, NULL));
  bccsplat_writer_release(writer);
}

static bccsplat_channel_info channel_of(bccsplat_device* device, const char* path, int32_t* store) {
  SIZED(bccsplat_channel_info, channel);
  SIZED(bccsplat_volume_info, info);
  bccsplat_volume* volume = NULL;
  OK(bccsplat_volume_open_file(device, path, NULL, &volume));
  OK(bccsplat_volume_get_channel_info(volume, 0, &channel));
  OK(bccsplat_volume_get_info(volume, &info));
  *store = info.store;
  bccsplat_volume_release(volume);
  channel.name = channel.unit = NULL; /* gone with the volume */
  return channel;
}

void test_recode(void) {
  bccsplat_device* device = NULL;
  bccsplat_volume *volume = NULL, *made = NULL;
  const char *source = scratch("bytes.bcc4"), *path = scratch("recoded.bcc4");
  SIZED(bccsplat_recode_options, options);
  SIZED(bccsplat_writer_report, report);
  bccsplat_channel_info channel;
  double point[4] = {5, 6, 5, 2.5};
  float before = 0, after = 0;
  int32_t store = 0;
  remove(path);
  OK(bccsplat_device_create(NULL, &device));
  write_bytes(device, source);
  OK(bccsplat_volume_open_file(device, source, NULL, &volume));
  OK(bccsplat_volume_evaluate(volume, 1, point, &before, NULL));
  EXPECT(before > 5);

  options.store = BCCSPLAT_STORE_COEFFICIENTS;
  OK(bccsplat_volume_recode(volume, path, &options, &report));
  EXPECT(report.frames == NT && report.cc_samples == (uint64_t)NT * SAMPLES && report.bytes_file > 0);
  channel = channel_of(device, path, &store);
  EXPECT(store == BCCSPLAT_STORE_COEFFICIENTS && channel.value_type == BCCSPLAT_TYPE_I32);
  OK(bccsplat_volume_open_file(device, path, NULL, &made));
  OK(bccsplat_volume_evaluate(made, 1, point, &after, NULL));
  EXPECT(fabsf(after - before) < 1.5f);
  bccsplat_volume_release(made);

  options.overwrite = 1;
  INPUT_SIZES(bccsplat_recode_options, options, bccsplat_volume_recode(volume, path, in, NULL), (void)0);
  OUTPUT_SIZES(bccsplat_writer_report, bccsplat_volume_recode(volume, path, &options, out), (void)0);
  options.value_type = BCCSPLAT_TYPE_F32, options.format = 2;
  OK(bccsplat_volume_recode(volume, path, &options, NULL));
  channel = channel_of(device, path, &store);
  EXPECT(store == BCCSPLAT_STORE_COEFFICIENTS && channel.value_type == BCCSPLAT_TYPE_F32);
  options.value_type = 0;
  REFUSED(UNSUPPORTED, "needs version 3", bccsplat_volume_recode(volume, path, &options, NULL));
  options.format = 5;
  REFUSED(INVALID_ARGUMENT, "format 5", bccsplat_volume_recode(volume, path, &options, NULL));
  options.format = 0, options.kernel = "paper";
  REFUSED(UNSUPPORTED, "cannot be stored", bccsplat_volume_recode(volume, path, &options, NULL));
  options.kernel = "radial77";
  REFUSED(NOT_FOUND, "radial", bccsplat_volume_recode(volume, path, &options, NULL));
  options.kernel = NULL, options.value_step = -1;
  REFUSED(INVALID_ARGUMENT, "value_step", bccsplat_volume_recode(volume, path, &options, NULL));
  options.value_step = 0, options.value_type = BCCSPLAT_TYPE_I16;
  REFUSED(INVALID_ARGUMENT, "value_type", bccsplat_volume_recode(volume, path, &options, NULL));
  options.value_type = 0, options.store = 7;
  REFUSED(INVALID_ARGUMENT, "store is 7", bccsplat_volume_recode(volume, path, &options, NULL));
  options.store = 0, options.reserved = 1;
  REFUSED(INVALID_ARGUMENT, "reserved", bccsplat_volume_recode(volume, path, &options, NULL));
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_recode(NULL, path, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "path is NULL", bccsplat_volume_recode(volume, NULL, NULL, NULL));
  REFUSED(FILE_EXISTS, "recoded.bcc4", bccsplat_volume_recode(volume, path, NULL, NULL));
  bccsplat_volume_release(volume);
  bccsplat_device_release(device);
}
