/* SPDX-License-Identifier: Apache-2.0 */
/* Plan: options that are chosen for a series of a host. */
#include "host.h"

#include <stdlib.h>

enum { MOST_REFINEMENTS = 3 };

/* The frames of the series; gives up at a frame, or counts those that were asked for. */
typedef struct {
  int64_t gives_up_at;
  int asked;
} frames;

static int32_t give_frame(void* user, uint64_t frame, uint32_t channel, void* values) {
  frames* f = user;
  EXPECT(frame < NT && channel == 0);
  if ((int64_t)frame == f->gives_up_at) return 1;
  ++f->asked;
  fill_frame(values, (double)frame);
  return 0;
}

static int32_t stop_at_once(void* user, double fraction) {
  *(double*)user = fraction;
  return 1;
}

static bccsplat_plan_options options_of(const bccsplat_writer_options* wish, frames* f) {
  SIZED(bccsplat_plan_options, o);
  o.wish = wish;
  o.frame = give_frame, o.frame_user = f;
  f->gives_up_at = -1, f->asked = 0;
  return o;
}

/* Writes the series as a plan says; how that ended. */
static bccsplat_status write_planned(bccsplat_device* device, const bccsplat_plan* plan, const char* path) {
  static float samples[SAMPLES];
  const bccsplat_box box = frame_box(samples);
  SIZED(bccsplat_writer_options, options);
  bccsplat_writer* writer = NULL;
  bccsplat_status status;
  int t;
  OK(bccsplat_plan_get_writer_options(plan, &options));
  OK(bccsplat_writer_create(device, path, &options, &writer));
  for (t = 0; t < NT; ++t) {
    fill_frame(samples, t);
    OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  }
  status = bccsplat_writer_finish(writer, NULL);
  bccsplat_writer_release(writer);
  return status;
}

static void chooses(bccsplat_device* device) {
  bccsplat_writer_options wish = series_options();
  frames f;
  const bccsplat_plan_options options = options_of(&wish, &f);
  SIZED(bccsplat_writer_options, chosen);
  bccsplat_plan* plan = NULL;
  const char* text = NULL;
  wish.store = BCCSPLAT_STORE_SAMPLES;
  OK(bccsplat_plan_create(device, &options, &plan));
  EXPECT(f.asked >= NT);
  OK(bccsplat_plan_get_writer_options(plan, &chosen));
  EXPECT(chosen.dims[0] == NX && chosen.dims[3] == NT && chosen.overwrite == 1);
  EXPECT(chosen.lattice != BCCSPLAT_LATTICE_DEFAULT && chosen.channel_count == 1);
  EXPECT(chosen.measure == BCCSPLAT_MEASURE_SOME && chosen.levels == 0);
  OK(bccsplat_plan_get_text(plan, &text));
  EXPECT(text != NULL && strlen(text) > 0);
  OUTPUT_SIZES(bccsplat_writer_options, bccsplat_plan_get_writer_options(plan, out), (void)0);
  EXPECT(write_planned(device, plan, scratch("planned.bcc4")) == BCCSPLAT_OK);
  bccsplat_plan_retain(plan);
  bccsplat_plan_release(plan);
  REFUSED(NOT_FOUND, "nothing is left", bccsplat_plan_refine(plan));
  bccsplat_plan_release(plan);
  bccsplat_plan_release(NULL);
}

/* The same series by boxes: each frame in two halves, which stay until they are let go of. */
typedef struct {
  int held;
  uint64_t most_samples; /* of what was asked for at once */
  int beyond;            /* gives a box that ends outside the frame */
} halves;
typedef struct {
  halves* of;
  bccsplat_box boxes[2];
  float samples[SAMPLES];
} half_frames;

static void let_go(void* keeper) {
  --((half_frames*)keeper)->of->held;
  free(keeper);
}

static int32_t give_halves(void* user, uint64_t frame, uint32_t channel, const uint64_t* begin,
                           const uint64_t* end, bccsplat_source_boxes* boxes) {
  half_frames* h = malloc(sizeof *h);
  const uint64_t samples = (end[0] - begin[0]) * (end[1] - begin[1]) * (end[2] - begin[2]);
  EXPECT(frame < NT && channel == 0 && end[0] <= NX && end[1] <= NY && end[2] <= NZ && samples > 0);
  if (!h) return 1;
  h->of = user, ++h->of->held;
  if (samples > h->of->most_samples) h->of->most_samples = samples;
  fill_frame(h->samples, (double)frame);
  h->boxes[0] = h->boxes[1] = frame_box(h->samples);
  h->boxes[0].dims[2] = NZ / 2;
  h->boxes[1].begin[2] = NZ / 2, h->boxes[1].dims[2] = NZ - NZ / 2 + h->of->beyond;
  h->boxes[1].data = h->samples + (size_t)NX * NY * (NZ / 2);
  boxes->boxes = h->boxes, boxes->count = 2;
  boxes->release = let_go, boxes->keeper = h;
  return 0;
}

static void takes_boxes(bccsplat_device* device) {
  halves h = {0, 0, 0};
  bccsplat_writer_options wish = series_options();
  frames f;
  bccsplat_plan_options options = options_of(&wish, &f);
  bccsplat_plan *dense = NULL, *boxes = NULL;
  const char *expected, *got;
  options.set_mask = BCCSPLAT_PLAN_EVERYTHING;
  OK(bccsplat_plan_create(device, &options, &dense));
  OK(bccsplat_plan_get_json(dense, &expected));
  EXPECT(strstr(expected, "\"channels\":[{\"range\":[") != NULL &&
         strstr(expected, "\"spectrum\":{") != NULL);
  options.frame = NULL, options.boxes = give_halves, options.frame_user = &h;
  OK(bccsplat_plan_create(device, &options, &boxes));
  OK(bccsplat_plan_get_json(boxes, &got));
  EXPECT(strcmp(expected, got) == 0 && h.held == 0 && h.most_samples == SAMPLES);
  bccsplat_plan_release(boxes), boxes = NULL;
  options.name = "the host's", h.beyond = 1;
  REFUSED(INVALID_ARGUMENT, "not within the frame", bccsplat_plan_create(device, &options, &boxes));
  EXPECT(boxes == NULL && h.held == 0);
  bccsplat_plan_release(dense);
}

/* What a file has that goes on is kept: its steps. */
static void keeps_steps(bccsplat_device* device) {
  bccsplat_writer_options wish = series_options();
  SIZED(bccsplat_channel_options, channel);
  SIZED(bccsplat_writer_options, chosen);
  frames f;
  bccsplat_plan_options options = options_of(&wish, &f);
  bccsplat_plan* plan = NULL;
  wish.store = BCCSPLAT_STORE_SAMPLES, wish.lattice = BCCSPLAT_LATTICE_D4STAR, wish.scale = 1;
  wish.channels = &channel, wish.channel_count = 1, options.exact = 1;
  channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE, channel.value_type = BCCSPLAT_TYPE_U16;
  channel.range[0] = -4, channel.range[1] = 4, channel.value_step = 0.01;
  OK(bccsplat_plan_create(device, &options, &plan));
  OK(bccsplat_plan_get_writer_options(plan, &chosen));
  EXPECT(chosen.channels[0].value_step == 0.01 && chosen.channels[0].value_type == BCCSPLAT_TYPE_U16);
  EXPECT(chosen.channels[0].range[0] == -4 && chosen.channels[0].range[1] == 4);
  bccsplat_plan_release(plan);
}

static void keeps_a_bound(bccsplat_device* device) {
  bccsplat_writer_options wish = series_options();
  frames f;
  const bccsplat_plan_options options = options_of(&wish, &f);
  SIZED(bccsplat_writer_options, chosen);
  bccsplat_plan* plan = NULL;
  int refined = 0;
  wish.psnr = 45;
  OK(bccsplat_plan_create(device, &options, &plan));
  OK(bccsplat_plan_get_writer_options(plan, &chosen));
  EXPECT(chosen.psnr == wish.psnr);
  while (write_planned(device, plan, scratch("bound.bcc4")) == BCCSPLAT_ERROR_BOUND_NOT_MET &&
         refined <= MOST_REFINEMENTS) {
    OK(bccsplat_plan_refine(plan));
    ++refined;
  }
  EXPECT(refined <= MOST_REFINEMENTS);
  for (; refined < MOST_REFINEMENTS; ++refined)
    if (bccsplat_plan_refine(plan) != BCCSPLAT_OK) break; /* corrections are the last */
  OK(bccsplat_plan_get_writer_options(plan, &chosen));
  EXPECT(chosen.abs_error > 0);
  REFUSED(NOT_FOUND, "nothing is left", bccsplat_plan_refine(plan));
  bccsplat_plan_release(plan);
}

static void refuses(bccsplat_device* device) {
  bccsplat_writer_options wish = series_options();
  SIZED(bccsplat_channel_options, channel);
  SIZED(bccsplat_series_part, part);
  SIZED(bccsplat_plan_channel, values);
  const double same[NT] = {0, 1, 1, 2, 3};
  frames f;
  bccsplat_plan_options o = options_of(&wish, &f);
  bccsplat_plan* plan = NULL;
  const char* text = NULL;
  REFUSED(INVALID_ARGUMENT, "plan is NULL", bccsplat_plan_create(device, &o, NULL));
  REFUSED(INVALID_ARGUMENT, "device is NULL", bccsplat_plan_create(NULL, &o, &plan));
  REFUSED(INVALID_ARGUMENT, "options is NULL", bccsplat_plan_create(device, NULL, &plan));
  o.set_mask = 32;
  REFUSED(INVALID_ARGUMENT, "unknown bits", bccsplat_plan_create(device, &o, &plan));
  o = options_of(NULL, &f);
  REFUSED(INVALID_ARGUMENT, "wish is NULL", bccsplat_plan_create(device, &o, &plan));
  o = options_of(&wish, &f), o.frame = NULL;
  REFUSED(INVALID_ARGUMENT, "frame is NULL", bccsplat_plan_create(device, &o, &plan));
  o = options_of(&wish, &f), o.times = same;
  REFUSED(INVALID_ARGUMENT, "times rise", bccsplat_plan_create(device, &o, &plan));
  o = options_of(&wish, &f), o.density = 5;
  REFUSED(INVALID_ARGUMENT, "density", bccsplat_plan_create(device, &o, &plan));
  wish.scale = 2, o.density = 0.5;
  REFUSED(INVALID_ARGUMENT, "one or the other", bccsplat_plan_create(device, &o, &plan));
  wish = series_options(), wish.dims[3] = 0, o.density = 0;
  REFUSED(INVALID_ARGUMENT, "counts from 1 on", bccsplat_plan_create(device, &o, &plan));
  wish = series_options(), wish.psnr = 50, wish.abs_error = 1;
  REFUSED(INVALID_ARGUMENT, "keeps one of them", bccsplat_plan_create(device, &o, &plan));
  wish = series_options(), wish.recommended_kernel = "none such";
  REFUSED(NOT_FOUND, "none such", bccsplat_plan_create(device, &o, &plan));
  wish = series_options(), wish.part = &part;
  REFUSED(UNSUPPORTED, "whole series", bccsplat_plan_create(device, &o, &plan));
  wish = series_options(), wish.channels = &channel, wish.channel_count = 1;
  channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE, channel.range[1] = 1;
  REFUSED(UNSUPPORTED, "finds range", bccsplat_plan_create(device, &o, &plan));
  wish = series_options(), values.kind = 1, o.channels = &values;
  REFUSED(INVALID_ARGUMENT, "not that of labels", bccsplat_plan_create(device, &o, &plan));
  o.channels = NULL, o.set_mask = BCCSPLAT_PLAN_LARGE_FRAMES;
  REFUSED(INVALID_ARGUMENT, "boxes is NULL", bccsplat_plan_create(device, &o, &plan));
  EXPECT(plan == NULL && f.asked == 0);
  REFUSED(INVALID_ARGUMENT, "plan is NULL", bccsplat_plan_get_writer_options(NULL, &wish));
  REFUSED(INVALID_ARGUMENT, "plan is NULL", bccsplat_plan_get_text(NULL, &text));
  REFUSED(INVALID_ARGUMENT, "plan is NULL", bccsplat_plan_get_json(NULL, &text));
  REFUSED(INVALID_ARGUMENT, "plan is NULL", bccsplat_plan_refine(NULL));
}

static void ends_when_told(bccsplat_device* device) {
  bccsplat_writer_options wish = series_options();
  bccsplat_cancel_token* token = NULL;
  bccsplat_plan* plan = NULL;
  double reached = -1;
  frames f;
  bccsplat_plan_options o = options_of(&wish, &f);
  f.gives_up_at = 2;
  EXPECT(bccsplat_plan_create(device, &o, &plan) == BCCSPLAT_CANCELLED && plan == NULL);
  EXPECT(strstr(bccsplat_last_error(), "frame 2") != NULL);
  f.gives_up_at = -1;
  wish.progress = stop_at_once, wish.progress_user = &reached;
  EXPECT(bccsplat_plan_create(device, &o, &plan) == BCCSPLAT_CANCELLED && plan == NULL);
  EXPECT(reached >= 0 && reached < 1);
  wish = series_options();
  OK(bccsplat_cancel_token_create(&token));
  OK(bccsplat_cancel_token_cancel(token));
  wish.cancel_token = token;
  EXPECT(bccsplat_plan_create(device, &o, &plan) == BCCSPLAT_CANCELLED && plan == NULL);
  bccsplat_cancel_token_release(token);
}

void test_plan(void) {
  bccsplat_writer_options wish = series_options();
  frames f;
  bccsplat_plan_options value;
  bccsplat_device* device = NULL;
  bccsplat_plan* plan = NULL;
  OK(bccsplat_device_create(NULL, &device));
  wish.lattice = BCCSPLAT_LATTICE_CC, wish.scale = 1;
  value = options_of(&wish, &f);
  INPUT_SIZES(bccsplat_plan_options, value, bccsplat_plan_create(device, in, &plan),
              bccsplat_plan_release(plan));
  chooses(device);
  takes_boxes(device);
  keeps_steps(device);
  keeps_a_bound(device);
  refuses(device);
  ends_when_told(device);
  bccsplat_device_release(device);
}
