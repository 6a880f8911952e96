/* SPDX-License-Identifier: Apache-2.0 */
/* Writer: frames, layers, streams; every wrong order and every wrong value. */
#include "host.h"

#include <float.h>
#include <math.h>
#include <unistd.h>

static float samples[SAMPLES];

static bccsplat_writer* make(bccsplat_device* device, const bccsplat_writer_options* options) {
  bccsplat_writer* writer = NULL;
  OK(bccsplat_writer_create(device, scratch("w.bcc4"), options, &writer));
  return writer;
}

/* Options that cannot work, one at a time. */
static void wrong_options(bccsplat_device* device) {
#define WRONG(status, word, ...)                                                                             \
  do {                                                                                                       \
    bccsplat_writer_options o = series_options();                                                            \
    bccsplat_writer* writer = (bccsplat_writer*)&o;                                                          \
    bccsplat_channel_options c[2] = {{.struct_size = sizeof *c}, {.struct_size = sizeof *c, .name = "b"}};   \
    o.channels = c;                                                                                          \
    o.channel_count = 2;                                                                                     \
    __VA_ARGS__;                                                                                             \
    REFUSED(status, word, bccsplat_writer_create(device, scratch("wrong.bcc4"), &o, &writer));               \
    EXPECT(!writer);                                                                                         \
  } while (0)
  WRONG(INVALID_ARGUMENT, "dims[1]", o.dims[1] = 0);
  WRONG(INVALID_ARGUMENT, "set_mask", o.set_mask = 1);
  WRONG(INVALID_ARGUMENT, "lattice", o.lattice = 4);
  WRONG(INVALID_ARGUMENT, "lattice BCC", o.lattice = BCCSPLAT_LATTICE_BCC);
  WRONG(INVALID_ARGUMENT, "nonfinite", o.nonfinite = 9);
  WRONG(INVALID_ARGUMENT, "store is 2", o.store = 2);
  WRONG(INVALID_ARGUMENT, "scale", o.scale = -2);
  WRONG(INVALID_ARGUMENT, "scale", o.time_scale = NAN);
  WRONG(INVALID_ARGUMENT, "scale", o.scales[1] = -1);
  WRONG(INVALID_ARGUMENT, "scale", o.scales[3] = 65537);
  WRONG(INVALID_ARGUMENT, "last row", o.affine[0] = 1);
  WRONG(INVALID_ARGUMENT, "span space", o.affine[15] = 1);
  WRONG(INVALID_ARGUMENT, "finite", o.affine[3] = INFINITY);
  WRONG(NOT_FOUND, "gaus", o.recommended_kernel = "gaus");
  WRONG(INVALID_ARGUMENT, "channels is NULL", o.channels = NULL);
  WRONG(INVALID_ARGUMENT, "1024", o.channel_count = 5000);
  WRONG(INVALID_ARGUMENT, "named", c[1].name = "value");
  WRONG(INVALID_ARGUMENT, "empty", c[1].name = "");
  WRONG(INVALID_ARGUMENT, "set_mask", c[1].set_mask = 16);
  WRONG(INVALID_ARGUMENT, "source_type", c[1].source_type = 10);
  WRONG(INVALID_ARGUMENT, "value_type", c[1].value_type = BCCSPLAT_TYPE_I16);
  WRONG(INVALID_ARGUMENT, "air", c[1].air = NAN);
  WRONG(INVALID_ARGUMENT, "threshold", c[1].air_threshold = -1);
  WRONG(INVALID_ARGUMENT, "range", c[1].set_mask = BCCSPLAT_CHANNEL_SET_RANGE);
  WRONG(INVALID_STRUCT_SIZE, "bccsplat_channel_options", c[1].struct_size = 3);
#undef WRONG
}

static void wrong_frames(bccsplat_device* device) {
  const bccsplat_writer_options options = series_options();
  /* Each is refused, and the writer is as it was. */
#define WRONG(status, word, ...)                                                                             \
  do {                                                                                                       \
    bccsplat_box box = frame_box(samples);                                                                   \
    bccsplat_writer* writer = make(device, &options);                                                        \
    double time = 0;                                                                                         \
    OK(bccsplat_writer_add_frame(writer, 0, -1, &box, 1));                                                   \
    __VA_ARGS__;                                                                                             \
    REFUSED(status, word, bccsplat_writer_add_frame(writer, 0, time, &box, 1));                              \
    REFUSED(WRONG_STATE, "given 1 frames, not 5", bccsplat_writer_finish(writer, NULL));                     \
    OK(bccsplat_writer_add_frame(writer, 0, 0, NULL, 0));                                                    \
    bccsplat_writer_release(writer);                                                                         \
    EXPECT(access(scratch("w.bcc4"), F_OK) != 0);                                                            \
  } while (0)
  WRONG(INVALID_ARGUMENT, "rise", time = -1);
  WRONG(INVALID_ARGUMENT, "finite", time = NAN);
  WRONG(INVALID_ARGUMENT, "type", box.type = BCCSPLAT_TYPE_DEFAULT);
  WRONG(INVALID_ARGUMENT, "type", box.type = 99);
  WRONG(INVALID_ARGUMENT, "box.data is NULL", box.data = NULL);
  WRONG(INVALID_ARGUMENT, "axis 0", box.begin[0] = 1);
  WRONG(INVALID_ARGUMENT, "axis 2", box.begin[2] = -1);
  WRONG(INVALID_ARGUMENT, "axis 1", box.dims[1] = 0);
  WRONG(INVALID_ARGUMENT, "axis 1", box.dims[1] = INT64_MAX);
  WRONG(INVALID_STRUCT_SIZE, "bccsplat_box", box.struct_size = 0);
  WRONG(NONFINITE_VALUE, "frame 1", samples[3 * NX + 2] = NAN);
  samples[3 * NX + 2] = 0;
#undef WRONG
}

static void wrong_order(bccsplat_device* device) {
  bccsplat_writer_options options = series_options();
  const bccsplat_box box = frame_box(samples);
  bccsplat_writer* writer = make(device, &options);
  int t;
  REFUSED(INVALID_ARGUMENT, "boxes is NULL", bccsplat_writer_add_frame(writer, 0, 0, NULL, 1));
  REFUSED(NOT_FOUND, "channel 1", bccsplat_writer_add_frame(writer, 1, 0, &box, 1)); /* neither was a step */
  for (t = 0; t < NT; ++t) OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  REFUSED(WRONG_STATE, "5 frames", bccsplat_writer_add_frame(writer, 0, NT, &box, 1));
  bccsplat_writer_release(writer);

  writer = make(device, &options);
  REFUSED(WRONG_STATE, "nothing was added", bccsplat_writer_finish(writer, NULL));
  REFUSED(WRONG_STATE, "nothing was added", bccsplat_writer_finish_short(writer, NULL));
  bccsplat_writer_release(writer);

  writer = make(device, &options); /* frames and layers do not mix */
  OK(bccsplat_writer_add_frame(writer, 0, 0, NULL, 0));
  REFUSED(WRONG_STATE, "mix", bccsplat_writer_add_layer(writer, 0, 1, samples, SAMPLES));
  bccsplat_writer_release(writer);

  options.dims[3] = 0;
  writer = make(device, &options);
  REFUSED(WRONG_STATE, "dims[3]", bccsplat_writer_add_layer(writer, 0, 0, samples, SAMPLES));
  bccsplat_writer_release(writer);
  EXPECT(access(scratch("w.bcc4"), F_OK) != 0);
}

static int32_t ask(void* user, uint64_t n, const double* xyzt, float* values) {
  uint64_t i;
  for (i = 0; i < n; ++i)
    values[i] = (float)(xyzt[4 * i] + 2 * xyzt[4 * i + 1] - xyzt[4 * i + 2] + xyzt[4 * i + 3]);
  return user != NULL;
}

static void fields(bccsplat_device* device) {
  bccsplat_writer_options options = series_options();
  SIZED(bccsplat_error_report, error);
  SIZED(bccsplat_writer_report, report);
  bccsplat_writer* writer;
  options.abs_error = 1e-3;
  writer = make(device, &options);
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_add_field(NULL, 0, ask, NULL));
  REFUSED(INVALID_ARGUMENT, "field is NULL", bccsplat_writer_add_field(writer, 0, NULL, NULL));
  REFUSED(NOT_FOUND, "channel 3", bccsplat_writer_add_field(writer, 3, ask, NULL));
  REFUSED(WRONG_STATE, "finish", bccsplat_writer_get_error(writer, 0, -1, &error));
  OK(bccsplat_writer_add_field(writer, 0, ask, NULL));
  OK(bccsplat_writer_finish(writer, &report));
  EXPECT(report.frames_measured == NT);
  REFUSED(NOT_FOUND, "measured", bccsplat_writer_get_error(writer, 0, NT, &error));
  REFUSED(NOT_FOUND, "channel 1", bccsplat_writer_get_error(writer, 1, 0, &error));
  OUTPUT_SIZES(bccsplat_error_report, bccsplat_writer_get_error(writer, 0, 0, out), (void)0);
  OK(bccsplat_writer_get_error(writer, 0, -1, &error));
  EXPECT(error.samples == SAMPLES * NT && error.max_abs <= 1e-3 && error.corrected == report.corrected);
  bccsplat_writer_release(writer);

  unlink(scratch("w.bcc4"));
  writer = make(device, &options);
  EXPECT(bccsplat_writer_add_field(writer, 0, ask, writer) == BCCSPLAT_CANCELLED);
  bccsplat_writer_release(writer);
}

static void layers(bccsplat_device* device) {
  bccsplat_writer_options options = series_options();
  SIZED(bccsplat_layer_geometry, g);
  SIZED(bccsplat_volume_info, info);
  bccsplat_writer* writer = make(device, &options);
  bccsplat_volume* volume = NULL;
  const double middle[4] = {5, 6, 5, 2};
  float value = 0;
  int64_t layer;
  uint64_t i, n;
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_get_layer_geometry(NULL, 0, &g));
  REFUSED(INVALID_ARGUMENT, "geometry is NULL", bccsplat_writer_get_layer_geometry(writer, 0, NULL));
  REFUSED(NOT_FOUND, "layer -1", bccsplat_writer_get_layer_geometry(writer, -1, &g));
  OUTPUT_SIZES(bccsplat_layer_geometry, bccsplat_writer_get_layer_geometry(writer, 0, out), (void)0);
  OK(bccsplat_writer_get_layer_geometry(writer, 0, &g));
  REFUSED(NOT_FOUND, "layer", bccsplat_writer_get_layer_geometry(writer, g.layer_count, &g));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_add_layer(NULL, 0, 0, samples, 1));
  REFUSED(INVALID_ARGUMENT, "samples is NULL", bccsplat_writer_add_layer(writer, 0, 0, NULL, 1));
  REFUSED(NOT_FOUND, "channel 7", bccsplat_writer_add_layer(writer, 7, 0, samples, 1));
  REFUSED(INVALID_ARGUMENT, "step", bccsplat_writer_set_times(writer, 0, 0));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_set_times(NULL, 0, 1));
  OK(bccsplat_writer_set_times(writer, 100, 5));
  for (i = 0; i < SAMPLES; ++i) samples[i] = 7;
  for (layer = 0; layer < g.layer_count; ++layer) {
    OK(bccsplat_writer_get_layer_geometry(writer, layer, &g));
    n = (uint64_t)(g.dims[0] * g.dims[1] * g.dims[2]);
    EXPECT(n > 0 && n <= SAMPLES && g.step[0] > 0 && g.frame >= -1 && g.frame <= NT);
    OK(bccsplat_writer_add_layer(writer, 0, layer, samples, n));
  }
  OK(bccsplat_writer_finish(writer, NULL));
  bccsplat_writer_release(writer);
  OK(bccsplat_volume_open_file(device, scratch("w.bcc4"), NULL, &volume));
  OK(bccsplat_volume_get_info(volume, &info));
  EXPECT(info.time_first == 100 && info.time_last == 100 + 5 * (NT - 1) && info.dims[3] == NT);
  OK(bccsplat_volume_evaluate(volume, 1, middle, &value, NULL));
  EXPECT(fabs(value - 7) < 0.05); /* the kernel's ripple */
  bccsplat_volume_release(volume);
  unlink(scratch("w.bcc4"));

  writer = make(device, &options);
  REFUSED(WRONG_STATE, "0 is next", bccsplat_writer_add_layer(writer, 0, 1, samples, 1));
  bccsplat_writer_release(writer);
  writer = make(device, &options);
  REFUSED(INVALID_ARGUMENT, "", bccsplat_writer_add_layer(writer, 0, 0, samples, 1)); /* wrong count */
  bccsplat_writer_release(writer);
}

static void short_series(bccsplat_device* device) {
  const bccsplat_writer_options options = series_options();
  const bccsplat_box box = frame_box(samples);
  SIZED(bccsplat_writer_report, report);
  bccsplat_writer* writer = make(device, &options);
  int t;
  for (t = 0; t < NT - 2; ++t) OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  REFUSED(WRONG_STATE, "3 frames, not 5", bccsplat_writer_finish(writer, NULL));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_finish_short(NULL, &report));
  report.struct_size = 7;
  REFUSED(INVALID_STRUCT_SIZE, "report", bccsplat_writer_finish_short(writer, &report));
  report.struct_size = sizeof report;
  OK(bccsplat_writer_finish_short(writer, &report));
  EXPECT(report.frames == NT - 2);
  bccsplat_writer_release(writer);
  unlink(scratch("w.bcc4"));
}

static unsigned char stored[64 * 1024];
static uint64_t stored_size;
static int64_t store_at(void* user, uint64_t offset, const void* buffer, uint64_t size) {
  int* fail = user;
  if (*fail || offset + size > sizeof stored) return -1;
  memcpy(stored + offset, buffer, size);
  if (offset + size > stored_size) stored_size = offset + size;
  return (int64_t)size;
}

static void streams(bccsplat_device* device) {
  const bccsplat_writer_options options = series_options();
  const bccsplat_box box = frame_box(samples);
  SIZED(bccsplat_write_stream, stream);
  SIZED(bccsplat_writer_report, report);
  bccsplat_writer* writer = NULL;
  bccsplat_volume* volume = NULL;
  bccsplat_status status = BCCSPLAT_OK;
  int fail = 0, t;
  REFUSED(INVALID_ARGUMENT, "device is NULL",
          bccsplat_writer_create_stream(NULL, &stream, &options, &writer));
  REFUSED(INVALID_ARGUMENT, "stream is NULL", bccsplat_writer_create_stream(device, NULL, &options, &writer));
  REFUSED(INVALID_ARGUMENT, "write_at", bccsplat_writer_create_stream(device, &stream, &options, &writer));
  stream.write_at = store_at;
  stream.user = &fail;
  REFUSED(INVALID_ARGUMENT, "options is NULL", bccsplat_writer_create_stream(device, &stream, NULL, &writer));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_create_stream(device, &stream, &options, NULL));
  INPUT_SIZES(bccsplat_write_stream, stream, bccsplat_writer_create_stream(device, in, &options, &writer),
              bccsplat_writer_release(writer));
  OK(bccsplat_writer_create_stream(device, &stream, &options, &writer));
  for (t = 0; t < NT; ++t) OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  OK(bccsplat_writer_finish(writer, &report));
  bccsplat_writer_release(writer);
  EXPECT(report.bytes_file == stored_size && report.frames == NT);
  OK(bccsplat_volume_open_memory(device, stored, stored_size, NULL, &volume));
  bccsplat_volume_release(volume);

  OK(bccsplat_writer_create_stream(device, &stream, &options, &writer));
  fail = 1;
  for (t = 0; t < NT && status == BCCSPLAT_OK; ++t) status = bccsplat_writer_add_frame(writer, 0, t, &box, 1);
  if (status == BCCSPLAT_OK) status = bccsplat_writer_finish(writer, NULL);
  EXPECT(status == BCCSPLAT_ERROR_IO && strstr(bccsplat_last_error(), "stream"));
  bccsplat_writer_release(writer);
}

void test_writer(void) {
  bccsplat_writer_options options = series_options();
  bccsplat_channel_options channel = {.struct_size = sizeof channel, .name = "density"};
  bccsplat_device* device = NULL;
  bccsplat_writer* writer = NULL;
  bccsplat_box box = frame_box(samples);

  OK(bccsplat_device_create(NULL, &device));
  fill_frame(samples, 0);
  options.channels = &channel;
  options.channel_count = 1;
  unlink(scratch("w.bcc4"));

  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_writer_create(NULL, "x", &options, &writer));
  REFUSED(INVALID_ARGUMENT, "path is NULL", bccsplat_writer_create(device, NULL, &options, &writer));
  REFUSED(INVALID_ARGUMENT, "options is NULL", bccsplat_writer_create(device, "x", NULL, &writer));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_create(device, "x", &options, NULL));
  REFUSED(FILE_NOT_FOUND, "no/such", bccsplat_writer_create(device, scratch("no/such"), &options, &writer));
  INPUT_SIZES(bccsplat_writer_options, options,
              bccsplat_writer_create(device, scratch("w.bcc4"), in, &writer),
              bccsplat_writer_release(writer));
  {
    bccsplat_writer_options o = options;
    INPUT_SIZES(bccsplat_channel_options, channel,
                (o.channels = in, bccsplat_writer_create(device, scratch("w.bcc4"), &o, &writer)),
                bccsplat_writer_release(writer));
  }
  wrong_options(device);
  wrong_frames(device);
  wrong_order(device);

  OK(bccsplat_writer_create(device, scratch("w.bcc4"), &options, &writer));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_add_frame(NULL, 0, 0, &box, 1));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_set_attribute(NULL, "k", "v"));
  REFUSED(INVALID_ARGUMENT, "key is NULL", bccsplat_writer_set_attribute(writer, NULL, "v"));
  REFUSED(INVALID_ARGUMENT, "value is NULL", bccsplat_writer_set_attribute(writer, "k", NULL));
  REFUSED(INVALID_ARGUMENT, "empty", bccsplat_writer_set_attribute(writer, "", "v"));
  OK(bccsplat_writer_set_attribute(writer, "k", "v"));
  OK(bccsplat_writer_set_attribute(writer, "k", "w"));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_add_source(NULL, "n", 1, 2));
  REFUSED(INVALID_ARGUMENT, "name is NULL", bccsplat_writer_add_source(writer, NULL, 1, 2));
  OK(bccsplat_writer_add_source(writer, "n", 1, 2));
  REFUSED(INVALID_ARGUMENT, "writer is NULL", bccsplat_writer_finish(NULL, NULL));
  bccsplat_writer_retain(writer);
  bccsplat_writer_release(writer);
  INPUT_SIZES(bccsplat_box, box,
              (bccsplat_writer_release(writer), writer = make(device, &options),
               bccsplat_writer_add_frame(writer, 0, 0, in, 1)),
              (void)0);
  bccsplat_writer_release(writer);
  writer = make(device, &options);
  {
    int t;
    for (t = 0; t < NT; ++t) OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  }
  EXPECT(access(scratch("w.bcc4"), F_OK) != 0); /* not before finish */
  {
    SIZED(bccsplat_writer_report, report);
    report.struct_size = 5;
    REFUSED(INVALID_STRUCT_SIZE, "report", bccsplat_writer_finish(writer, &report)); /* before any work */
    report.struct_size = sizeof report;
    OK(bccsplat_writer_finish(writer, &report));
    EXPECT(report.frames == NT && report.sites_kept > 0 && report.sites_kept <= report.sites_total);
  }
  EXPECT(access(scratch("w.bcc4"), F_OK) == 0);
  REFUSED(WRONG_STATE, "finished", bccsplat_writer_finish(writer, NULL));
  REFUSED(WRONG_STATE, "finished", bccsplat_writer_add_frame(writer, 0, 99, NULL, 0));
  REFUSED(WRONG_STATE, "finished", bccsplat_writer_add_layer(writer, 0, 0, samples, 1));
  bccsplat_writer_release(writer);
  options.overwrite = 0;
  REFUSED(FILE_EXISTS, "w.bcc4", bccsplat_writer_create(device, scratch("w.bcc4"), &options, &writer));
  unlink(scratch("w.bcc4"));
  bccsplat_writer_retain(NULL);
  bccsplat_writer_release(NULL);
  fields(device);
  layers(device);
  short_series(device);
  streams(device);
  bccsplat_device_release(device);
}
