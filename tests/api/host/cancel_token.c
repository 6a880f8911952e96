/* SPDX-License-Identifier: Apache-2.0 */
/* Cancel token: it stays until it is reset, and every long call that has it ends. */
#include "host.h"

#include <signal.h>

static bccsplat_cancel_token* at_signal;
static void on_signal(int number) {
  (void)number;
  bccsplat_cancel_token_cancel(at_signal);
}

static void states(bccsplat_cancel_token* token) {
  int32_t cancelled = 7;
  OK(bccsplat_cancel_token_is_cancelled(token, &cancelled));
  EXPECT(cancelled == 0);
  OK(bccsplat_cancel_token_cancel(token));
  OK(bccsplat_cancel_token_cancel(token));
  OK(bccsplat_cancel_token_is_cancelled(token, &cancelled));
  EXPECT(cancelled == 1);
  OK(bccsplat_cancel_token_reset(token));
  OK(bccsplat_cancel_token_is_cancelled(token, &cancelled));
  EXPECT(cancelled == 0);
  at_signal = token;
  signal(SIGINT, on_signal);
  raise(SIGINT);
  signal(SIGINT, SIG_DFL);
  OK(bccsplat_cancel_token_is_cancelled(token, &cancelled));
  EXPECT(cancelled == 1);
  OK(bccsplat_cancel_token_reset(token));
}

static void misuse(bccsplat_cancel_token* token, bccsplat_device* device) {
  bccsplat_cancel_token* other_kind = (bccsplat_cancel_token*)device;
  SIZED(bccsplat_volume_options, options);
  bccsplat_volume* volume = (bccsplat_volume*)device;
  int32_t cancelled = 7;
  REFUSED(INVALID_ARGUMENT, "token is NULL", bccsplat_cancel_token_create(NULL));
  REFUSED(INVALID_ARGUMENT, "token is NULL", bccsplat_cancel_token_cancel(NULL));
  REFUSED(INVALID_ARGUMENT, "token is NULL", bccsplat_cancel_token_reset(NULL));
  REFUSED(INVALID_ARGUMENT, "token is NULL", bccsplat_cancel_token_is_cancelled(NULL, &cancelled));
  REFUSED(INVALID_ARGUMENT, "cancelled is NULL", bccsplat_cancel_token_is_cancelled(token, NULL));
  REFUSED(INVALID_HANDLE, "another kind", bccsplat_cancel_token_cancel(other_kind));
  bccsplat_cancel_token_retain(other_kind);
  bccsplat_cancel_token_release(other_kind);
  bccsplat_cancel_token_retain(NULL);
  bccsplat_cancel_token_release(NULL);
  options.cancel_token = other_kind;
  REFUSED(INVALID_HANDLE, "another kind",
          bccsplat_volume_open_file(device, scratch("cancel.bcc4"), &options, &volume));
  EXPECT(volume == NULL && cancelled == 7);
}

#define CANCELLED_CALL(call)                                                                                 \
  EXPECT((call) == BCCSPLAT_CANCELLED && strstr(bccsplat_last_error(), "cancelled"))

/* All of them, before they begin; afterwards all go on. */
static void calls(bccsplat_cancel_token* token, bccsplat_device* device) {
  const char* path = scratch("cancel.bcc4");
  const char* other = scratch("never.bcc4");
  const bccsplat_hyperplane plane = at_frame(1.5);
  const double at[4] = {5, 5, 5, 1};
  static float values[SAMPLES];
  SIZED(bccsplat_volume_options, opening);
  SIZED(bccsplat_slice_options, cutting);
  SIZED(bccsplat_render_options, drawing);
  SIZED(bccsplat_join_options, joining);
  SIZED(bccsplat_verify_report, report);
  bccsplat_writer_options writing = series_options();
  bccsplat_volume *volume = NULL, *none = NULL;
  bccsplat_slice *slice = NULL, *no_slice = NULL;
  bccsplat_renderer* renderer = NULL;
  bccsplat_frame* frame = NULL;
  bccsplat_writer* writer = NULL;
  opening.cancel_token = cutting.cancel_token = drawing.cancel_token = token;
  joining.cancel_token = writing.cancel_token = token;
  OK(bccsplat_volume_open_file(device, path, &opening, &volume));
  OK(bccsplat_slice_create(volume, &plane, &cutting, &slice));
  OK(bccsplat_renderer_create(device, &renderer));
  OK(bccsplat_renderer_set_slice(renderer, slice));
  OK(bccsplat_renderer_set_options(renderer, &drawing));
  OK(bccsplat_frame_create(device, 20, 20, BCCSPLAT_FRAME_RGBA, &frame));

  OK(bccsplat_cancel_token_cancel(token));
  CANCELLED_CALL(bccsplat_volume_open_file(device, path, &opening, &none));
  CANCELLED_CALL(bccsplat_volume_evaluate(volume, 1, at, values, NULL));
  CANCELLED_CALL(bccsplat_volume_verify(volume, NULL, NULL, &report));
  CANCELLED_CALL(bccsplat_volume_prefetch(volume, &plane, NULL)); /* the volume's */
  CANCELLED_CALL(bccsplat_slice_create(volume, &plane, NULL, &no_slice));
  CANCELLED_CALL(bccsplat_slice_evaluate(slice, 1, at, values, NULL));
  CANCELLED_CALL(bccsplat_slice_sample_grid(slice, NULL, values));
  CANCELLED_CALL(bccsplat_slice_get_points(slice, 0, NULL, NULL, NULL));
  CANCELLED_CALL(bccsplat_renderer_render(renderer, frame));
  CANCELLED_CALL(bccsplat_join_parts(device, 1, &path, other, &joining, NULL));
  CANCELLED_CALL(bccsplat_writer_create(device, other, &writing, &writer));
  EXPECT(none == NULL && no_slice == NULL && writer == NULL);

  OK(bccsplat_cancel_token_reset(token));
  OK(bccsplat_volume_evaluate(volume, 1, at, values, NULL));
  OK(bccsplat_slice_sample_grid(slice, NULL, values));
  OK(bccsplat_renderer_render(renderer, frame));
  bccsplat_cancel_token_release(token); /* they keep it */
  OK(bccsplat_renderer_render(renderer, frame));
  OK(bccsplat_volume_verify(volume, NULL, NULL, &report));
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  bccsplat_slice_release(slice);
  bccsplat_volume_release(volume);
}

/* A writer that refused a call for its token takes it afterwards. */
static void writer_goes_on(bccsplat_cancel_token* token, bccsplat_device* device) {
  bccsplat_writer_options options = series_options();
  SIZED(bccsplat_writer_report, report);
  bccsplat_writer* writer = NULL;
  static float samples[SAMPLES];
  const bccsplat_box box = frame_box(samples);
  int t;
  options.cancel_token = token;
  OK(bccsplat_writer_create(device, scratch("goes_on.bcc4"), &options, &writer));
  for (t = 0; t < NT; ++t) {
    fill_frame(samples, t);
    OK(bccsplat_cancel_token_cancel(token));
    CANCELLED_CALL(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
    OK(bccsplat_cancel_token_reset(token));
    OK(bccsplat_writer_add_frame(writer, 0, t, &box, 1));
  }
  OK(bccsplat_cancel_token_cancel(token));
  CANCELLED_CALL(bccsplat_writer_finish(writer, &report));
  OK(bccsplat_cancel_token_reset(token));
  OK(bccsplat_writer_finish(writer, &report));
  EXPECT(report.frames == NT);
  bccsplat_writer_release(writer);
}

void test_cancel_token(void) {
  bccsplat_device* device = NULL;
  bccsplat_cancel_token* token = NULL;
  OK(bccsplat_device_create(NULL, &device));
  OK(bccsplat_cancel_token_create(&token));
  write_series(device, scratch("cancel.bcc4"));
  states(token);
  misuse(token, device);
  writer_goes_on(token, device);
  bccsplat_cancel_token_retain(token);
  calls(token, device);
  bccsplat_cancel_token_release(token);
  bccsplat_device_release(device);
}
