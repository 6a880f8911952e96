/* SPDX-License-Identifier: Apache-2.0 */
/* plan_host RAW TYPE LIKE.bcc4 OUT.bcc4 [psnr=N] [abs=N] [density=N] [store=wavelets] [measure=all] ...:
 * writes the values of RAW, x fastest, as a plan of the C API says. What an import knows of its files comes
 * from LIKE: size, channel, place, times, attributes and sources. Prints what was chosen. */
#include <bccsplat.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  unsigned char* values;
  uint64_t frame_bytes;
} source;

static void check(bccsplat_status status, const char* call) {
  if (status == BCCSPLAT_OK) return;
  fprintf(stderr, "%s: %s (%s)\n", call, bccsplat_last_error(), bccsplat_status_name(status));
  exit(1);
}
#define OK(call) check((call), #call)

static int32_t give_frame(void* user, uint64_t frame, uint32_t channel, void* values) {
  const source* s = user;
  memcpy(values, s->values + frame * s->frame_bytes, s->frame_bytes);
  return channel != 0;
}

static unsigned char* read_all(const char* path, uint64_t bytes) {
  unsigned char* values = malloc(bytes);
  FILE* file = fopen(path, "rb");
  if (!values || !file || fread(values, 1, bytes, file) != bytes) {
    fprintf(stderr, "%s: not %llu bytes\n", path, (unsigned long long)bytes);
    exit(1);
  }
  fclose(file);
  return values;
}

static bccsplat_type type_named(const char* name, uint64_t* bytes) {
  static const struct {
    const char* name;
    bccsplat_type type;
    uint64_t bytes;
  } types[] = {{"u8", BCCSPLAT_TYPE_U8, 1}, {"u16", BCCSPLAT_TYPE_U16, 2}, {"f32", BCCSPLAT_TYPE_F32, 4}};
  size_t i;
  for (i = 0; i < sizeof types / sizeof *types; ++i)
    if (strcmp(types[i].name, name) == 0) {
      *bytes = types[i].bytes;
      return types[i].type;
    }
  fprintf(stderr, "%s: not a type of this host\n", name);
  exit(1);
}

static void read_wish(const char* text, bccsplat_plan_options* o, bccsplat_writer_options* w) {
  const char* value = strchr(text, '=');
  if (!value++) value = "";
  if (strncmp(text, "psnr=", 5) == 0)
    w->psnr = atof(value);
  else if (strncmp(text, "abs=", 4) == 0)
    w->abs_error = atof(value);
  else if (strncmp(text, "density=", 8) == 0)
    o->density = atof(value);
  else if (strcmp(text, "store=wavelets") == 0)
    w->store = BCCSPLAT_STORE_WAVELETS;
  else if (strcmp(text, "lattice=cc") == 0)
    w->lattice = BCCSPLAT_LATTICE_CC;
  else if (strcmp(text, "ends=mirror") == 0)
    w->ends = BCCSPLAT_ENDS_MIRROR;
  else if (strcmp(text, "exact") == 0)
    o->exact = 1;
  else {
    fprintf(stderr, "%s: not a wish of this host\n", text);
    exit(1);
  }
}

/* What an import writes beside the values. */
static void copy_origin(const bccsplat_volume* like, uint64_t attributes, bccsplat_writer* writer) {
  const char *key, *value;
  uint64_t i, bytes;
  uint32_t crc32;
  for (i = 0; i < attributes; ++i) {
    OK(bccsplat_volume_get_attribute(like, i, &key, &value));
    OK(bccsplat_writer_set_attribute(writer, key, value));
  }
  for (i = 0; bccsplat_volume_get_source(like, i, &key, &bytes, &crc32) == BCCSPLAT_OK; ++i)
    OK(bccsplat_writer_add_source(writer, key, bytes, crc32));
}

static bccsplat_status write_series(bccsplat_device* device, const bccsplat_plan* plan, const source* s,
                                    const bccsplat_volume* like, const double* times, const char* path) {
  bccsplat_writer_options options = BCCSPLAT_INIT(bccsplat_writer_options);
  bccsplat_volume_info info = BCCSPLAT_INIT(bccsplat_volume_info);
  bccsplat_box box = BCCSPLAT_INIT(bccsplat_box);
  bccsplat_writer* writer = NULL;
  bccsplat_status status;
  uint64_t f;
  int a;
  OK(bccsplat_volume_get_info(like, &info));
  OK(bccsplat_plan_get_writer_options(plan, &options));
  OK(bccsplat_writer_create(device, path, &options, &writer));
  copy_origin(like, info.attribute_count, writer);
  box.type = options.channels[0].source_type;
  for (a = 0; a < 3; ++a) box.dims[a] = options.dims[a];
  for (f = 0; f < options.dims[3]; ++f) {
    box.data = s->values + f * s->frame_bytes;
    OK(bccsplat_writer_add_frame(writer, 0, times[f], &box, 1));
  }
  status = bccsplat_writer_finish(writer, NULL);
  bccsplat_writer_release(writer);
  return status;
}

int main(int argc, char** argv) {
  bccsplat_plan_options options = BCCSPLAT_INIT(bccsplat_plan_options);
  bccsplat_writer_options wish = BCCSPLAT_INIT(bccsplat_writer_options);
  bccsplat_channel_options channel = BCCSPLAT_INIT(bccsplat_channel_options);
  bccsplat_plan_channel values = BCCSPLAT_INIT(bccsplat_plan_channel);
  bccsplat_volume_info info = BCCSPLAT_INIT(bccsplat_volume_info);
  bccsplat_channel_info known = BCCSPLAT_INIT(bccsplat_channel_info);
  bccsplat_device* device = NULL;
  bccsplat_volume* like = NULL;
  bccsplat_plan* plan = NULL;
  bccsplat_status status;
  source s;
  double* times;
  const char* text;
  int i;
  if (argc < 5) {
    fprintf(stderr, "usage: plan_host RAW TYPE LIKE.bcc4 OUT.bcc4 [WISH]...\n");
    return 2;
  }
  OK(bccsplat_device_create(NULL, &device));
  OK(bccsplat_volume_open_file(device, argv[3], NULL, &like));
  OK(bccsplat_volume_get_info(like, &info));
  OK(bccsplat_volume_get_channel_info(like, 0, &known));
  for (i = 0; i < 4; ++i) wish.dims[i] = (uint32_t)info.dims[i];
  memcpy(wish.affine, info.affine, sizeof wish.affine);
  wish.spatial_unit = info.spatial_unit, wish.time_unit = info.time_unit;
  channel.name = known.name, channel.unit = known.unit;
  wish.channels = &channel, wish.channel_count = 1;
  times = malloc(info.dims[3] * sizeof *times);
  OK(bccsplat_volume_get_times(like, times, info.dims[3], NULL));
  values.type = type_named(argv[2], &s.frame_bytes);
  s.frame_bytes *= info.dims[0] * info.dims[1] * info.dims[2];
  s.values = read_all(argv[1], s.frame_bytes * info.dims[3]);
  options.wish = &wish, options.channels = &values, options.times = times;
  options.frame = give_frame, options.frame_user = &s;
  for (i = 5; i < argc; ++i) read_wish(argv[i], &options, &wish);
  OK(bccsplat_plan_create(device, &options, &plan));
  while ((status = write_series(device, plan, &s, like, times, argv[4])) == BCCSPLAT_ERROR_BOUND_NOT_MET)
    OK(bccsplat_plan_refine(plan));
  check(status, "finish");
  OK(bccsplat_plan_get_text(plan, &text));
  printf("%s\n", text);
  bccsplat_plan_release(plan);
  bccsplat_volume_release(like);
  bccsplat_device_release(device);
  free(times), free(s.values);
  return 0;
}
