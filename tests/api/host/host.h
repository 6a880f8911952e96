// SPDX-License-Identifier: Apache-2.0
/* Hosts in C99: checks that count, and a small series to work on. */
#ifndef BCCSPLAT_TEST_HOST_H
#define BCCSPLAT_TEST_HOST_H

#include <bccsplat.h>

#include <stdio.h>
#include <string.h>

extern int failures;

#define EXPECT(condition)                                                                                    \
  do {                                                                                                       \
    if (!(condition)) {                                                                                      \
      fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                \
      ++failures;                                                                                            \
    }                                                                                                        \
  } while (0)

/* A call that must succeed. */
#define OK(call) expect_ok((call), #call, __FILE__, __LINE__)
/* A call that must fail with a status and a text that holds a word. */
#define REFUSED(status, word, call)                                                                          \
  expect_refused(BCCSPLAT_ERROR_##status, word, (call), #call, __FILE__, __LINE__)
void expect_ok(bccsplat_status got, const char* call, const char* file, int line);
void expect_refused(bccsplat_status wanted, const char* word, bccsplat_status got, const char* call,
                    const char* file, int line);

/* A cleared struct that knows its size. */
#define SIZED(type, name) type name = BCCSPLAT_INIT(type)

/* How a call takes an input struct `in` of each size: not set, of a newer header with its new fields clear
 * and set. `after` undoes a call that succeeded. */
#define INPUT_SIZES(type, value, call, after)                                                                \
  do {                                                                                                       \
    struct {                                                                                                 \
      type known;                                                                                            \
      uint64_t tail[2];                                                                                      \
    } newer;                                                                                                 \
    type* in = &newer.known;                                                                                 \
    memset(&newer, 0, sizeof newer);                                                                         \
    newer.known = (value);                                                                                   \
    in->struct_size = 0;                                                                                     \
    REFUSED(INVALID_STRUCT_SIZE, #type ": struct_size is 0", call);                                          \
    in->struct_size = 7;                                                                                     \
    REFUSED(INVALID_STRUCT_SIZE, #type ": struct_size is 7", call);                                          \
    in->struct_size = sizeof newer;                                                                          \
    OK(call);                                                                                                \
    after;                                                                                                   \
    newer.tail[1] = 1;                                                                                       \
    REFUSED(INVALID_STRUCT_SIZE, "update the library", call);                                                \
    in->struct_size = sizeof(type);                                                                          \
    OK(call);                                                                                                \
    after;                                                                                                   \
  } while (0)

/* How a call fills an output struct `out` of each size: of an older header (nothing beyond its 8 bytes is
 * touched), of a newer one (neither), not set. `again` makes the call possible once more. */
#define OUTPUT_SIZES(type, call, again)                                                                      \
  do {                                                                                                       \
    struct {                                                                                                 \
      type known;                                                                                            \
      uint64_t tail;                                                                                         \
    } newer;                                                                                                 \
    type* out = &newer.known;                                                                                \
    memset(&newer, 0xAB, sizeof newer);                                                                      \
    out->struct_size = 4;                                                                                    \
    REFUSED(INVALID_STRUCT_SIZE, "struct_size is 4", call);                                                  \
    EXPECT(untouched(&newer, 4, sizeof newer));                                                              \
    out->struct_size = 8;                                                                                    \
    OK(call);                                                                                                \
    EXPECT(out->struct_size == 8 && untouched(&newer, 8, sizeof newer));                                     \
    again;                                                                                                   \
    out->struct_size = sizeof newer;                                                                         \
    OK(call);                                                                                                \
    EXPECT(out->struct_size == sizeof newer && untouched(&newer, sizeof(type), sizeof newer));               \
    EXPECT(!untouched(&newer, 8, sizeof(type)));                                                             \
  } while (0)
/* Bytes [begin, end) still hold 0xAB. */
int untouched(const void* bytes, size_t begin, size_t end);

/* 13 x 12 x 11 voxels, 5 frames: a blob that moves along x, values 0 .. 100, air 0. */
enum { NX = 13, NY = 12, NZ = 11, NT = 5, SAMPLES = NX * NY * NZ };
void fill_frame(float* samples, double frame);
bccsplat_box frame_box(const float* samples);
/* Of that series, without anything special. */
bccsplat_writer_options series_options(void);
void write_series(bccsplat_device* device, const char* path);
bccsplat_volume* open_series(bccsplat_device* device, const char* path);
bccsplat_hyperplane at_frame(double frame);
/* A path in the scratch folder of this run; at most four are valid at a time. */
const char* scratch(const char* name);
/* Threads of this process. */
int thread_count(void);

/* One per object, each in the file of its name. */
void test_library(void);
void test_device(void);
void test_writer(void);
void test_parts(void);
void test_volume(void);
void test_slice(void);
void test_bricks(void);
void test_renderer(void);
void test_frame(void);
void test_scene(void);
void test_plan(void);
void test_cancel_token(void);
void test_streams(void);
void test_hygiene(void);

#endif
