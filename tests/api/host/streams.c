/* SPDX-License-Identifier: Apache-2.0 */
/* Streams: bytes that are late and are asked for in advance, joined files and images in memory.
 */
#include "host.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 256 * 1024 };

/* A file of which only the bytes up to `there` have arrived. */
struct late_file {
  unsigned char bytes[MOST];
  uint64_t size, there;
};

static int64_t read_late(void* user, uint64_t offset, void* buffer, uint64_t size) {
  const struct late_file* file = user;
  if (offset + size > file->there) return BCCSPLAT_READ_WOULD_BLOCK;
  memcpy(buffer, file->bytes + offset, size);
  return (int64_t)size;
}

struct output {
  unsigned char bytes[MOST];
  uint64_t size;
  int flushes;
};

static int64_t write_output(void* user, uint64_t offset, const void* buffer, uint64_t size) {
  struct output* out = user;
  if (offset + size > MOST) return -1;
  memcpy(out->bytes + offset, buffer, size);
  if (offset + size > out->size) out->size = offset + size;
  return (int64_t)size;
}

static int32_t flush_output(void* user) {
  ++((struct output*)user)->flushes;
  return 0;
}

static bccsplat_write_stream stream_to(struct output* out) {
  SIZED(bccsplat_write_stream, stream);
  memset(out, 0, sizeof *out);
  stream.write_at = write_output;
  stream.flush = flush_output;
  stream.user = out;
  return stream;
}

static uint64_t load(const char* path, unsigned char* bytes) {
  FILE* file = fopen(path, "rb");
  const size_t size = file ? fread(bytes, 1, MOST, file) : 0;
  if (file) fclose(file);
  EXPECT(size > 0 && size < MOST);
  return size;
}

/* What is lacking, what is going to be read. */
static void late(bccsplat_device* device, struct late_file* file, bccsplat_read_stream stream) {
  const bccsplat_hyperplane plane = at_frame(1.5);
  bccsplat_volume* volume = NULL;
  bccsplat_slice* slice = NULL;
  uint64_t lacking[2] = {7, 7}, count = 0, ranges[64], i;
  OK(bccsplat_last_lacking(NULL, 0, &count));
  EXPECT(count == 0);
  file->there = 100;
  REFUSED(WOULD_BLOCK, "not there yet", bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  EXPECT(!volume);
  OK(bccsplat_last_lacking(lacking, 1, &count));
  EXPECT(count == 1 && lacking[0] == 0 && lacking[1] > 100);
  REFUSED(INVALID_ARGUMENT, "ranges is NULL", bccsplat_last_lacking(NULL, 1, &count));
  file->there = file->size;
  OK(bccsplat_volume_open_stream(device, &stream, NULL, &volume));
  file->there = 0;
  REFUSED(WOULD_BLOCK, "not there yet", bccsplat_slice_create(volume, &plane, NULL, &slice));
  EXPECT(!slice);
  OK(bccsplat_last_lacking(lacking, 1, NULL));
  EXPECT(lacking[1] > 0 && lacking[0] + lacking[1] <= file->size);
  file->there = file->size;
  OK(bccsplat_volume_get_ranges(volume, &plane, NULL, 0, ranges, 32, &count));
  EXPECT(count >= 1 && count <= 32);
  for (i = 0; i < count && i < 32; ++i) EXPECT(ranges[2 * i] + ranges[2 * i + 1] <= file->size);
  REFUSED(INVALID_ARGUMENT, "volume is NULL",
          bccsplat_volume_get_ranges(NULL, &plane, NULL, 0, NULL, 0, NULL));
  REFUSED(INVALID_ARGUMENT, "ranges is NULL",
          bccsplat_volume_get_ranges(volume, &plane, NULL, 0, NULL, 1, NULL));
  REFUSED(INVALID_ARGUMENT, "flags 6", bccsplat_volume_get_ranges(volume, &plane, NULL, 6, NULL, 0, NULL));
  REFUSED(INVALID_ARGUMENT, "hyperplane is NULL",
          bccsplat_volume_get_ranges(volume, NULL, NULL, 0, NULL, 0, NULL));
  OK(bccsplat_slice_create(volume, &plane, NULL, &slice));
  OK(bccsplat_volume_get_ranges(volume, &plane, NULL, BCCSPLAT_RANGES_MISSING, NULL, 0, &count));
  EXPECT(count == 0);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
}

static void files(bccsplat_device* device, const bccsplat_read_stream* whole) {
  static struct output out;
  bccsplat_write_stream stream = stream_to(&out);
  const bccsplat_write_stream nowhere = {.struct_size = sizeof nowhere};
  SIZED(bccsplat_join_options, join);
  SIZED(bccsplat_writer_report, report);
  REFUSED(INVALID_ARGUMENT, "not a part", bccsplat_join_streams(device, 1, whole, &stream, &join, &report));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_join_streams(NULL, 1, whole, &stream, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "parts is NULL", bccsplat_join_streams(device, 1, NULL, &stream, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "stream is NULL", bccsplat_join_streams(device, 1, whole, NULL, &join, NULL));
  REFUSED(INVALID_ARGUMENT, "no parts", bccsplat_join_streams(device, 0, NULL, &stream, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "write_at", bccsplat_join_streams(device, 1, whole, &nowhere, &join, NULL));
}

static void images(bccsplat_device* device) {
  static struct output out;
  static unsigned char bytes[MOST];
  bccsplat_write_stream stream = stream_to(&out);
  SIZED(bccsplat_image_options, options);
  bccsplat_frame* frame = NULL;
  uint64_t size = 0;
  OK(bccsplat_frame_create(device, 40, 30, BCCSPLAT_FRAME_RGBA, &frame));
  if (strstr(bccsplat_build_info(), "image=none")) {
    REFUSED(MISSING_FEATURE, "BCCSPLAT_WITH_IMAGE",
            bccsplat_frame_save_memory(frame, BCCSPLAT_IMAGE_PNG, NULL, NULL, 0, &size));
  } else {
    OK(bccsplat_frame_save_memory(frame, BCCSPLAT_IMAGE_PNG, &options, bytes, sizeof bytes, &size));
    EXPECT(size > 50 && size < 40 * 30 * 8 + 65536 && memcmp(bytes, "\x89PNG", 4) == 0);
    OK(bccsplat_frame_save_stream(frame, BCCSPLAT_IMAGE_PNG, &stream, &options));
    EXPECT(out.size == size && memcmp(out.bytes, bytes, size) == 0 && out.flushes == 1);
    OK(bccsplat_frame_save_memory(frame, BCCSPLAT_IMAGE_EXR, NULL, bytes, 4, &size));
    EXPECT(size > 4 && memcmp(bytes, "\x76\x2f\x31\x01", 4) == 0);
  }
  REFUSED(NOT_FOUND, "FRAME_DEEP",
          bccsplat_frame_save_memory(frame, BCCSPLAT_IMAGE_DEEP_EXR, NULL, NULL, 0, &size));
  REFUSED(INVALID_ARGUMENT, "format", bccsplat_frame_save_memory(frame, 0, NULL, NULL, 0, &size));
  REFUSED(INVALID_ARGUMENT, "bytes is NULL",
          bccsplat_frame_save_memory(frame, BCCSPLAT_IMAGE_PNG, NULL, NULL, 1, &size));
  REFUSED(INVALID_ARGUMENT, "frame is NULL",
          bccsplat_frame_save_memory(NULL, BCCSPLAT_IMAGE_PNG, NULL, NULL, 0, &size));
  REFUSED(INVALID_ARGUMENT, "stream is NULL",
          bccsplat_frame_save_stream(frame, BCCSPLAT_IMAGE_PNG, NULL, NULL));
  REFUSED(INVALID_ARGUMENT, "format", bccsplat_frame_save_stream(frame, 9, &stream, NULL));
  REFUSED(INVALID_ARGUMENT, "frame is NULL",
          bccsplat_frame_save_stream(NULL, BCCSPLAT_IMAGE_PNG, &stream, NULL));
  bccsplat_frame_release(frame);
}

void test_streams(void) {
  static struct late_file file;
  SIZED(bccsplat_read_stream, stream);
  bccsplat_device* device = NULL;
  OK(bccsplat_device_create(NULL, &device));
  write_series(device, scratch("late.bcc4"));
  file.size = file.there = load(scratch("late.bcc4"), file.bytes);
  stream.size = file.size;
  stream.read_at = read_late;
  stream.user = &file;
  stream.merge_gap = 1 << 16;
  late(device, &file, stream);
  files(device, &stream);
  images(device);
  bccsplat_device_release(device);
}
