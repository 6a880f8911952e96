// SPDX-License-Identifier: Apache-2.0
// What answers where the library was built without its writer.
#include "api/guard.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

bccsplat_status without_writer() {
  return guard([] {
    fail(Code::missing_feature,
         "the library was built to read .bcc4 files, not to write them; build it with BCCSPLAT_WITH_WRITER");
  });
}

} // namespace

extern "C" {

bccsplat_status bccsplat_writer_create(bccsplat_device* /*device*/, const char* /*path*/,
                                       const bccsplat_writer_options* /*options*/, bccsplat_writer** writer) {
  if (writer) *writer = nullptr;
  return without_writer();
}
bccsplat_status bccsplat_writer_create_stream(bccsplat_device* /*device*/,
                                              const bccsplat_write_stream* /*stream*/,
                                              const bccsplat_writer_options* /*options*/,
                                              bccsplat_writer** writer) {
  if (writer) *writer = nullptr;
  return without_writer();
}
bccsplat_status bccsplat_writer_add_frame(bccsplat_writer* /*writer*/, uint32_t /*channel*/, double /*time*/,
                                          const bccsplat_box* /*boxes*/, uint64_t /*count*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_get_part_frames(const bccsplat_writer* /*writer*/, uint64_t* /*begin*/,
                                                uint64_t* /*end*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_get_layer_geometry(const bccsplat_writer* /*writer*/, int64_t /*layer*/,
                                                   bccsplat_layer_geometry* /*geometry*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_add_layer(bccsplat_writer* /*writer*/, uint32_t /*channel*/,
                                          int64_t /*layer*/, const float* /*samples*/, uint64_t /*count*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_add_field(bccsplat_writer* /*writer*/, uint32_t /*channel*/,
                                          bccsplat_field_fn /*field*/, void* /*user*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_set_times(bccsplat_writer* /*writer*/, double /*first*/, double /*step*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_set_attribute(bccsplat_writer* /*writer*/, const char* /*key*/,
                                              const char* /*value*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_add_source(bccsplat_writer* /*writer*/, const char* /*name*/,
                                           uint64_t /*bytes*/, uint32_t /*crc32*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_finish(bccsplat_writer* /*writer*/, bccsplat_writer_report* /*report*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_finish_short(bccsplat_writer* /*writer*/,
                                             bccsplat_writer_report* /*report*/) {
  return without_writer();
}
bccsplat_status bccsplat_writer_get_error(const bccsplat_writer* /*writer*/, uint32_t /*channel*/,
                                          int64_t /*measured*/, bccsplat_error_report* /*error*/) {
  return without_writer();
}
bccsplat_status bccsplat_plan_create(bccsplat_device* /*device*/, const bccsplat_plan_options* /*options*/,
                                     bccsplat_plan** plan) {
  if (plan) *plan = nullptr;
  return without_writer();
}
bccsplat_status bccsplat_plan_get_writer_options(const bccsplat_plan* /*plan*/,
                                                 bccsplat_writer_options* /*options*/) {
  return without_writer();
}
bccsplat_status bccsplat_plan_get_text(const bccsplat_plan* /*plan*/, const char** /*text*/) {
  return without_writer();
}
bccsplat_status bccsplat_plan_get_json(const bccsplat_plan* /*plan*/, const char** /*json*/) {
  return without_writer();
}
bccsplat_status bccsplat_plan_refine(bccsplat_plan* /*plan*/) { return without_writer(); }
bccsplat_status bccsplat_join_parts(bccsplat_device* /*device*/, uint64_t /*count*/,
                                    const char* const* /*parts*/, const char* /*path*/,
                                    const bccsplat_join_options* /*options*/,
                                    bccsplat_writer_report* /*report*/) {
  return without_writer();
}
bccsplat_status bccsplat_join_streams(bccsplat_device* /*device*/, uint64_t /*count*/,
                                      const bccsplat_read_stream* /*parts*/,
                                      const bccsplat_write_stream* /*stream*/,
                                      const bccsplat_join_options* /*options*/,
                                      bccsplat_writer_report* /*report*/) {
  return without_writer();
}
void bccsplat_plan_retain(bccsplat_plan* /*plan*/) {}
void bccsplat_plan_release(bccsplat_plan* /*plan*/) {}
bccsplat_status bccsplat_writer_get_part_box(const bccsplat_writer* /*writer*/, uint64_t* /*begin*/,
                                             uint64_t* /*end*/) {
  return without_writer();
}
void bccsplat_writer_retain(bccsplat_writer* /*writer*/) {}
void bccsplat_writer_release(bccsplat_writer* /*writer*/) {}

} // extern "C"
