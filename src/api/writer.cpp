// SPDX-License-Identifier: Apache-2.0
// Checks what a host gives a writer, boxes above all, whose strides must not reach beyond memory, and passes
// it on to VolumeWriter; joins parts. Options and reports are translated in writer_options.cpp.
#include "api/writer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "api/numbers.h"
#include "api/streams.h"
#include "api/structs.h"
#include "api/texts.h"
#include "store/join.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

// make_stream returns null for a file at `path`.
template<class MakeStream>
bccsplat_status create(bccsplat_device* device, const char* path, const bccsplat_writer_options* options,
                       bccsplat_writer** writer, const MakeStream& make_stream) {
  return guard([&] {
    require(writer, "writer");
    *writer = nullptr;
    require(device, "device"), require(options, "options");
    const auto o = read_struct(options, "bccsplat_writer_options");
    WriterSettings settings = read_writer_settings(o, path);
    std::unique_ptr<ByteSink> stream = make_stream();
    *writer = std::make_unique<bccsplat_writer>(device, o, std::move(settings), std::move(stream)).release();
  });
}

// Returns whether the last element of an array lies where no address can be.
bool runs_over(const bccsplat_box& box) {
  constexpr int64_t memory = memory_end;
  int64_t reach = 0;
  for (size_t a = 0; a < 3; ++a) {
    int64_t along = 0;
    const int64_t steps = std::max<int64_t>(box.dims[a], 1) - 1;
    if (__builtin_mul_overflow(steps, box.stride_bytes[a], &along) || along == INT64_MIN ||
        __builtin_add_overflow(reach, std::abs(along), &reach) || reach > memory)
      return true;
  }
  return false;
}

FrameBox read_box(const bccsplat_box* boxes, uint64_t i) {
  const auto box = read_struct(element(boxes, i), "bccsplat_box");
  if (box.type < BCCSPLAT_TYPE_U8 || box.type > BCCSPLAT_TYPE_U32)
    fail(Code::invalid_argument, "box ", i, ": type ", box.type, " is not a type of values");
  require(box.data, "box.data");
  if (runs_over(box)) fail(Code::invalid_argument, "box ", i, ": its strides reach further than memory");
  FrameBox out;
  out.type = static_cast<SourceType>(box.type);
  out.data = box.data;
  for (size_t a = 0; a < 3; ++a)
    out.begin[a] = box.begin[a], out.dims[a] = box.dims[a], out.stride[a] = box.stride_bytes[a];
  return out;
}

template<class Finish>
bccsplat_status finish(bccsplat_writer* writer, bccsplat_writer_report* report, const Finish& run) {
  return guard([&] {
    const Alone alone(writer, "writer");
    check_output(report, "report");
    writer->progress.begin_call();
    write_report(report, run(writer->writer));
    for (const std::string& text : writer->writer.warnings()) writer->device->log(BCCSPLAT_LOG_WARNING, text);
  });
}

template<class Run>
bccsplat_status join(bccsplat_device* device, const bccsplat_join_options* options,
                     bccsplat_writer_report* report, const Run& run) {
  return guard([&] {
    require(device, "device");
    check_output(report, "report");
    const auto o = read_struct(options, "bccsplat_join_options");
    require_zero(o.reserved, "bccsplat_join_options.reserved");
    const Token token = read_token(o.cancel_token);
    Progress progress(progress_callback(o.progress, o.progress_user));
    watch(progress, token);
    progress.throw_if_cancelled();
    write_report(report, run(o, device->context(progress)));
  });
}

} // namespace

extern "C" {

bccsplat_status bccsplat_writer_create(bccsplat_device* device, const char* path,
                                       const bccsplat_writer_options* options, bccsplat_writer** writer) {
  return create(device, path, options, writer, [&]() -> std::unique_ptr<ByteSink> {
    require(path, "path");
    return nullptr;
  });
}

bccsplat_status bccsplat_writer_create_stream(bccsplat_device* device, const bccsplat_write_stream* stream,
                                              const bccsplat_writer_options* options,
                                              bccsplat_writer** writer) {
  return create(device, nullptr, options, writer, [&] { return sink_of(stream); });
}

bccsplat_status bccsplat_writer_add_frame(bccsplat_writer* writer, uint32_t channel, double time,
                                          const bccsplat_box* boxes, uint64_t count) {
  return guard([&] {
    const Alone alone(writer, "writer");
    if (count > 0) require(boxes, "boxes");
    writer->writer.require_channel(channel);
    if (count > UINT32_MAX) fail(Code::invalid_argument, "count: ", count, " boxes of one frame");
    require_number(time, "time");
    writer->progress.begin_call();
    std::vector<FrameBox> frame;
    frame.reserve(count);
    for (uint64_t i = 0; i < count; ++i) frame.push_back(read_box(boxes, i));
    writer->writer.add_frame(channel, time, frame);
  });
}

bccsplat_status bccsplat_writer_get_layer_geometry(const bccsplat_writer* writer, int64_t layer,
                                                   bccsplat_layer_geometry* geometry) {
  return guard([&] {
    const Shared shared(writer, "writer");
    const LayerGeometry g = writer->writer.layer_geometry(layer);
    bccsplat_layer_geometry out{};
    out.coset = g.coset;
    for (size_t a = 0; a < 3; ++a)
      out.dims[a] = g.sites.dims[a], out.origin[a] = g.sites.origin[a], out.step[a] = g.sites.step[a];
    out.frame = g.sites.frame;
    out.layer_count = g.layers;
    write_struct(geometry, out, "geometry");
  });
}

bccsplat_status bccsplat_writer_add_layer(bccsplat_writer* writer, uint32_t channel, int64_t layer,
                                          const float* samples, uint64_t count) {
  return guard([&] {
    const Alone alone(writer, "writer");
    require(samples, "samples");
    require_count(count, sizeof(float), "count");
    writer->progress.begin_call();
    writer->writer.add_layer(channel, layer, {samples, count});
  });
}

bccsplat_status bccsplat_writer_add_field(bccsplat_writer* writer, uint32_t channel, bccsplat_field_fn field,
                                          void* user) {
  return guard([&] {
    const Alone alone(writer, "writer");
    if (!field) fail(Code::invalid_argument, "field is NULL");
    writer->progress.begin_call();
    writer->writer.add_field(channel, [&](std::span<const double> points, std::span<float> values) {
      return field(user, values.size(), points.data(), values.data()) == 0;
    });
  });
}

bccsplat_status bccsplat_writer_get_error(const bccsplat_writer* writer, uint32_t channel, int64_t measured,
                                          bccsplat_error_report* error) {
  return guard([&] {
    const Shared shared(writer, "writer");
    const auto [frame, peak, e] = writer->writer.measured(channel, measured);
    bccsplat_error_report out{};
    out.frame = frame;
    out.peak = peak;
    out.samples = e.all.count, out.max_abs = e.all.largest, out.rmse = e.all.rms();
    out.psnr = e.all.psnr(out.peak);
    out.non_air_samples = e.non_air.count, out.non_air_max_abs = e.non_air.largest;
    out.non_air_rmse = e.non_air.rms(), out.non_air_psnr = e.non_air.psnr(out.peak);
    std::copy(e.voxel.begin(), e.voxel.end(), out.voxel);
    out.expected = e.expected, out.got = e.got;
    out.uncorrected_max_abs = e.bare.largest;
    out.corrected = e.corrected, out.lost = e.lost;
    write_struct(error, out, "error");
  });
}

bccsplat_status bccsplat_writer_set_times(bccsplat_writer* writer, double first, double step) {
  return guard([&] {
    const Alone alone(writer, "writer");
    require_number(first, "first");
    require_range(step, smallest_length, largest_number, "step");
    writer->writer.set_times(first, step);
  });
}

bccsplat_status bccsplat_writer_set_attribute(bccsplat_writer* writer, const char* key, const char* value) {
  return guard([&] {
    const Alone alone(writer, "writer");
    require(key, "key"), require(value, "value");
    if (!*key) fail(Code::invalid_argument, "the key is empty");
    require_utf8(key, "key"), require_utf8(value, "value");
    writer->writer.set_attribute(key, value);
  });
}

bccsplat_status bccsplat_writer_add_source(bccsplat_writer* writer, const char* name, uint64_t bytes,
                                           uint32_t crc32) {
  return guard([&] {
    const Alone alone(writer, "writer");
    require(name, "name");
    require_utf8(name, "name");
    writer->writer.add_source({name, bytes, crc32});
  });
}

bccsplat_status bccsplat_writer_finish(bccsplat_writer* writer, bccsplat_writer_report* report) {
  return finish(writer, report, [](VolumeWriter& w) { return w.finish(); });
}

bccsplat_status bccsplat_writer_finish_short(bccsplat_writer* writer, bccsplat_writer_report* report) {
  return finish(writer, report, [](VolumeWriter& w) { return w.finish_short(); });
}

bccsplat_status bccsplat_writer_get_part_frames(const bccsplat_writer* writer, uint64_t* begin,
                                                uint64_t* end) {
  return guard([&] {
    const Shared shared(writer, "writer");
    require(begin, "begin"), require(end, "end");
    const auto frames = writer->writer.given_frames();
    *begin = frames[0], *end = frames[1];
  });
}

bccsplat_status bccsplat_writer_get_part_box(const bccsplat_writer* writer, uint64_t* begin, uint64_t* end) {
  return guard([&] {
    const Shared shared(writer, "writer");
    require(begin, "begin"), require(end, "end");
    const Region box = writer->writer.given_samples();
    for (size_t a = 0; a < 3; ++a) begin[a] = box.begin[a], end[a] = box.end[a];
  });
}

void bccsplat_writer_retain(bccsplat_writer* writer) { retain(writer); }
void bccsplat_writer_release(bccsplat_writer* writer) { release(writer); }

bccsplat_status bccsplat_join_parts(bccsplat_device* device, uint64_t count, const char* const* parts,
                                    const char* path, const bccsplat_join_options* options,
                                    bccsplat_writer_report* report) {
  return join(device, options, report, [&](const bccsplat_join_options& o, const Context& context) {
    require(path, "path");
    require_count(count, sizeof *parts, "count");
    if (count > 0) require(parts, "parts");
    std::vector<std::string> paths;
    for (uint64_t i = 0; i < count; ++i) {
      require(parts[i], "parts[i]");
      paths.emplace_back(parts[i]);
    }
    return join_parts(open_parts(paths), path, o.overwrite != 0, o.compare_levels != 0, context);
  });
}

bccsplat_status bccsplat_join_streams(bccsplat_device* device, uint64_t count,
                                      const bccsplat_read_stream* parts, const bccsplat_write_stream* stream,
                                      const bccsplat_join_options* options, bccsplat_writer_report* report) {
  return join(device, options, report, [&](const bccsplat_join_options& o, const Context& context) {
    require_count(count, sizeof *parts, "count");
    if (count > 0) require(parts, "parts");
    std::unique_ptr<ByteSink> sink = sink_of(stream);
    std::vector<std::unique_ptr<ByteSource>> sources;
    for (uint64_t i = 0; i < count; ++i) sources.push_back(source_of(element(parts, i), concat("part ", i)));
    return join_parts(open_parts(std::move(sources)), std::move(sink), o.compare_levels != 0, context);
  });
}

} // extern "C"
