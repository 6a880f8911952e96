#include "api/writer.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

template<class MakeSink>
bccsplat_status create(bccsplat_device* device, const bccsplat_writer_options* options,
                       bccsplat_writer** writer, const MakeSink& make_sink) {
  return guard([&] {
    require(writer, "writer");
    *writer = nullptr;
    require(device, "device"), require(options, "options");
    const auto o = read_struct(options, "bccsplat_writer_options");
    auto result = std::make_unique<bccsplat_writer>(device, o);
    result->sink = make_sink(o, *result);
    *writer = result.release();
  });
}

} // namespace

extern "C" {

bccsplat_status bccsplat_writer_create(bccsplat_device* device, const char* path,
                                       const bccsplat_writer_options* options, bccsplat_writer** writer) {
  return create(device, options, writer, [&](const bccsplat_writer_options& o, bccsplat_writer& result) {
    require(path, "path");
    result.path = path;
    if (o.partial == BCCSPLAT_PARTIAL_APPEND) {
      if (!file_exists(path)) fail(Code::file_not_found, path, ": no file to append to");
      if (o.part) result.begin_continued(read_struct(o.part, "bccsplat_series_part"));
      return create_file_sink(path, true);
    }
    return create_file_sink(path, o.overwrite != 0,
                            o.partial == BCCSPLAT_PARTIAL_DEFAULT ? Partial::removed
                            : o.partial == BCCSPLAT_PARTIAL_KEEP  ? Partial::kept
                                                                  : Partial::taken_over);
  });
}

bccsplat_status bccsplat_writer_create_stream(bccsplat_device* device, const bccsplat_write_stream* stream,
                                              const bccsplat_writer_options* options,
                                              bccsplat_writer** writer) {
  return create(device, options, writer, [&](const bccsplat_writer_options& o, bccsplat_writer&) {
    require(stream, "stream");
    if (o.partial != BCCSPLAT_PARTIAL_DEFAULT)
      fail(Code::unsupported,
           "writer: a stream's unfinished work is the host's own; partial must be DEFAULT");
    const auto s = read_struct(stream, "bccsplat_write_stream");
    require_zero(s.reserved, "bccsplat_write_stream.reserved");
    if (!s.write_at) fail(Code::invalid_argument, "bccsplat_write_stream.write_at is NULL");
    return create_stream_sink([s](uint64_t offset, std::span<const std::byte> bytes) {
      return s.write_at(s.user, offset, bytes.data(), bytes.size());
    });
  });
}

bccsplat_status bccsplat_writer_add_frame(bccsplat_writer* writer, uint32_t channel, double time,
                                          const bccsplat_box* boxes, uint64_t count) {
  return guard([&] {
    require(writer, "writer");
    if (count > 0) require(boxes, "boxes");
    writer->check_channel(channel);
    writer->step([&] { writer->add_frame(channel, time, boxes, count); });
  });
}

bccsplat_status bccsplat_writer_get_layer_geometry(const bccsplat_writer* writer, int64_t layer,
                                                   bccsplat_layer_geometry* geometry) {
  return guard([&] {
    require(writer, "writer");
    if (writer->fit_options.dims[3] == 0)
      fail(Code::wrong_state, "layers need the number of frames: set dims[3]");
    const Lattice4 lattice = writer->fit_options.part
                                 ? writer->initial.lattice
                                 : Lattice4::fit(writer->fit_options.lattice, writer->fit_options.dims,
                                                 writer->fit_options.scale, writer->fit_options.time_scale);
    if (layer < 0 || layer >= lattice.layers())
      fail(Code::not_found, "layer ", layer, " of ", lattice.layers());
    bccsplat_layer_geometry out{};
    out.coset = lattice.coset(static_cast<int32_t>(layer));
    const Int3 n = lattice.space.dims(out.coset);
    const Vec3 origin = lattice.site_position(out.coset, {0, 0, 0}),
               next = lattice.site_position(out.coset, {1, 1, 1});
    for (size_t a = 0; a < 3; ++a)
      out.dims[a] = n[a], out.origin[a] = origin[a], out.step[a] = next[a] - origin[a];
    out.frame = lattice.is_static() ? 0 : lattice.layer_frame(static_cast<int32_t>(layer));
    out.layer_count = lattice.layers();
    write_struct(geometry, out, "geometry");
  });
}

bccsplat_status bccsplat_writer_add_layer(bccsplat_writer* writer, uint32_t channel, int64_t layer,
                                          const float* samples, uint64_t count) {
  return guard([&] {
    require(writer, "writer"), require(samples, "samples");
    writer->check_channel(channel);
    writer->step([&] { writer->add_layer(channel, layer, {samples, count}); });
  });
}

bccsplat_status bccsplat_writer_add_field(bccsplat_writer* writer, uint32_t channel, bccsplat_field_fn field,
                                          void* user) {
  return guard([&] {
    require(writer, "writer");
    if (!field) fail(Code::invalid_argument, "field is NULL");
    writer->check_channel(channel);
    writer->step([&] { writer->add_field(channel, field, user); });
  });
}

bccsplat_status bccsplat_writer_get_error(const bccsplat_writer* writer, uint32_t channel, int64_t measured,
                                          bccsplat_error_report* error) {
  return guard([&] {
    require(writer, "writer");
    writer->check_channel(channel);
    if (!writer->finished) fail(Code::wrong_state, "writer: errors are known after finish");
    const RoundTrip* r = writer->round_trip.get();
    if (!r || measured < -1 || measured >= static_cast<int64_t>(r->frames().size()))
      fail(Code::not_found, "measured frame ", measured, " of ", r ? r->frames().size() : 0);
    const auto index = static_cast<int>(channel);
    const SampleErrors& e =
        measured < 0 ? r->errors(index) : r->frame_errors(index, static_cast<size_t>(measured));
    const Range& range = writer->source_ranges[channel];
    bccsplat_error_report out{};
    out.frame = measured < 0 ? e.frame : r->frames()[static_cast<size_t>(measured)];
    out.peak = range.high - range.low;
    out.samples = e.all.count, out.max_abs = e.all.largest, out.rmse = e.all.rms();
    out.psnr = e.all.psnr(out.peak);
    out.non_air_samples = e.non_air.count, out.non_air_max_abs = e.non_air.largest;
    out.non_air_rmse = e.non_air.rms(), out.non_air_psnr = e.non_air.psnr(out.peak);
    std::copy(e.voxel.begin(), e.voxel.end(), out.voxel);
    out.expected = e.expected, out.got = e.got;
    out.uncorrected_max_abs = e.uncorrected;
    out.corrected = e.corrected, out.lost = e.lost;
    write_struct(error, out, "error");
  });
}

bccsplat_status bccsplat_writer_set_times(bccsplat_writer* writer, double first, double step) {
  return guard([&] {
    require(writer, "writer");
    if (!std::isfinite(first) || !(step > 0 && std::isfinite(step)))
      fail(Code::invalid_argument, "times: first must be finite and step > 0");
    writer->require_open();
    writer->initial.time.first = first, writer->initial.time.step = step;
  });
}

bccsplat_status bccsplat_writer_set_attribute(bccsplat_writer* writer, const char* key, const char* value) {
  return guard([&] {
    require(writer, "writer"), require(key, "key"), require(value, "value");
    if (!*key) fail(Code::invalid_argument, "the key is empty");
    writer->require_open();
    auto& attributes = writer->initial.attributes;
    const auto it =
        std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.first == key; });
    if (it != attributes.end())
      it->second = value;
    else
      attributes.emplace_back(key, value);
  });
}

bccsplat_status bccsplat_writer_add_source(bccsplat_writer* writer, const char* name, uint64_t bytes,
                                           uint32_t crc32) {
  return guard([&] {
    require(writer, "writer"), require(name, "name");
    writer->require_open();
    writer->initial.sources.push_back({name, bytes, crc32});
  });
}

bccsplat_status bccsplat_writer_finish(bccsplat_writer* writer, bccsplat_writer_report* report) {
  return guard([&] {
    require(writer, "writer");
    check_output(report, "report");
    bccsplat_writer_report out{};
    writer->step([&] { out = writer->finish(); });
    if (report) write_struct(report, out, "report");
  });
}

void bccsplat_writer_retain(bccsplat_writer* writer) { retain(writer); }
void bccsplat_writer_release(bccsplat_writer* writer) { release(writer); }

} // extern "C"
