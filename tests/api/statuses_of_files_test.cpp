// SPDX-License-Identifier: Apache-2.0
// What writers, joins, opening and volumes may answer.
#include "statuses.h"

namespace host::statuses {
namespace {

TEST(Statuses, OfMakingWriters) {
  expect_rows({
      {"file exists", BCCSPLAT_ERROR_FILE_EXISTS, [](Scene& s) { return s.create(s.path, s.options()); }},
      {"no folder", BCCSPLAT_ERROR_FILE_NOT_FOUND,
       [](Scene& s) { return s.create(s.folder.file("no/x.bcc4"), s.options()); }},
      {"a folder", BCCSPLAT_ERROR_IO,
       [](Scene& s) {
         auto o = s.options();
         o.overwrite = 1;
         return s.create(s.folder.path().string(), o);
       }},
      {"kernel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto o = s.options();
         o.recommended_kernel = "none such";
         return s.create(s.folder.file("x.bcc4"), o);
       }},
      {"periodic and live", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = s.options();
         o.ends = BCCSPLAT_ENDS_PERIODIC, o.live = 1;
         return s.create(s.folder.file("x.bcc4"), o);
       }},
      {"layers of too many sites", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) {
         auto o = s.options();
         o.dims[0] = o.dims[1] = o.dims[2] = 60000, o.lattice = BCCSPLAT_LATTICE_CC;
         return bccsplat_writer_add_frame(s.writer(o).get(), 0, 0, nullptr, 0); // all of it air
       }},
      {"another writer of the path", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         const Writer first = s.writer(s.options(), "x.bcc4");
         return s.create(s.folder.file("x.bcc4"), s.options());
       }},
      {"nothing to append to", BCCSPLAT_ERROR_FILE_NOT_FOUND,
       [](Scene& s) {
         auto o = s.options();
         o.partial = BCCSPLAT_PARTIAL_APPEND;
         return s.create(s.folder.file("x.bcc4"), o);
       }},
      {"appending to another lattice", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         auto o = s.options();
         o.partial = BCCSPLAT_PARTIAL_APPEND, o.lattice = BCCSPLAT_LATTICE_CC, o.dims[3] = 12;
         return s.create(s.path, o);
       }},
      {"partial of a stream", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = s.options();
         o.partial = BCCSPLAT_PARTIAL_KEEP;
         Sink sink;
         const auto stream = sink.stream();
         bccsplat_writer* w = nullptr;
         return bccsplat_writer_create_stream(s.device.get(), &stream, &o, &w);
       }},
  });
}

TEST(Statuses, OfWriters) {
  const auto number = [](void*, uint64_t n, const double*, float* values) {
    std::fill_n(values, n, 1.0f);
    return int32_t{0};
  };
  static const bccsplat_field_fn ones = number;
  static const bccsplat_field_fn gives_up = [](void*, uint64_t, const double*, float*) { return int32_t{1}; };
  expect_rows({
      {"no such channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return add_frames(s.writer(s.options()).get(), s.series, 1); }},
      {"a NaN", BCCSPLAT_ERROR_NONFINITE_VALUE,
       [](Scene& s) {
         s.series.field = [](double, double, double, double) { return std::nan(""); };
         return add_frames(s.writer(s.options()).get(), s.series);
       }},
      {"far from air", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) {
         s.series.field = [](double, double, double, double) { return 1e37; };
         return add_frames(s.writer(s.options()).get(), s.series);
       }},
      {"a frame too many", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         const Writer w = s.writer(s.options());
         EXPECT_OK(add_frames(w.get(), s.series));
         return bccsplat_writer_add_frame(w.get(), 0, 100, nullptr, 0);
       }},
      {"a write that fails", BCCSPLAT_ERROR_IO,
       [](Scene& s) {
         Sink sink;
         sink.fail_at = 0;
         const auto stream = sink.stream();
         const auto o = s.options();
         bccsplat_writer* w = nullptr;
         bccsplat_status status = bccsplat_writer_create_stream(s.device.get(), &stream, &o, &w);
         const Writer writer(w);
         if (status == BCCSPLAT_OK) status = add_frames(w, s.series);
         if (status == BCCSPLAT_OK) status = bccsplat_writer_finish(w, nullptr);
         return status;
       }},
      {"geometry without a number of frames", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         auto o = s.options();
         o.dims[3] = 0;
         auto g = sized<bccsplat_layer_geometry>();
         return bccsplat_writer_get_layer_geometry(s.writer(o).get(), 0, &g);
       }},
      {"geometry past the last layer", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto g = sized<bccsplat_layer_geometry>();
         return bccsplat_writer_get_layer_geometry(s.writer(s.options()).get(), 1000, &g);
       }},
      {"a field with levels", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = s.options();
         o.levels = 1;
         return bccsplat_writer_add_field(s.writer(o).get(), 0, ones, nullptr);
       }},
      {"a field that gives up", BCCSPLAT_CANCELLED,
       [](Scene& s) { return bccsplat_writer_add_field(s.writer(s.options()).get(), 0, gives_up, nullptr); }},
      {"a layer with a bound", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         auto o = s.options();
         o.abs_error = 1;
         const Writer w = s.writer(o);
         auto g = sized<bccsplat_layer_geometry>();
         EXPECT_OK(bccsplat_writer_get_layer_geometry(w.get(), 0, &g));
         const std::vector<float> samples(static_cast<size_t>(g.dims[0] * g.dims[1] * g.dims[2]));
         return bccsplat_writer_add_layer(w.get(), 0, 0, samples.data(), samples.size());
       }},
      {"times behind frames", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         const Writer w = s.writer(s.options());
         EXPECT_OK(add_frames(w.get(), s.series));
         return bccsplat_writer_set_times(w.get(), 0, 1);
       }},
      {"an attribute behind finish", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         const Writer w = s.finished(s.options());
         EXPECT_EQ(bccsplat_writer_add_source(w.get(), "x", 1, 1), BCCSPLAT_ERROR_WRONG_STATE);
         EXPECT_EQ(bccsplat_writer_finish(w.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE);
         return bccsplat_writer_set_attribute(w.get(), "a", "b");
       }},
      {"an attribute of 65 MiB", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) {
         const std::string large(65u << 20, 'x');
         return bccsplat_writer_set_attribute(s.writer(s.options()).get(), "a", large.c_str());
       }},
      {"a source of 65 MiB", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) {
         const std::string large(65u << 20, 'x');
         return bccsplat_writer_add_source(s.writer(s.options()).get(), large.c_str(), 1, 1);
       }},
      {"finish too early", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) { return bccsplat_writer_finish(s.writer(s.options()).get(), nullptr); }},
      {"a PSNR that is missed", BCCSPLAT_ERROR_BOUND_NOT_MET,
       [](Scene& s) {
         auto o = s.options();
         o.psnr = 200;
         const Writer w = s.writer(o);
         EXPECT_OK(add_frames(w.get(), s.series));
         return bccsplat_writer_finish(w.get(), nullptr);
       }},
      {"finish_short of nothing", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) { return bccsplat_writer_finish_short(s.writer(s.options()).get(), nullptr); }},
      {"finish_short of a periodic series", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = s.options();
         o.ends = BCCSPLAT_ENDS_PERIODIC;
         const Writer w = s.writer(o);
         Series some = s.series;
         some.nt = 5;
         EXPECT_OK(add_frames(w.get(), some));
         return bccsplat_writer_finish_short(w.get(), nullptr);
       }},
      {"errors before finish", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         auto e = sized<bccsplat_error_report>();
         return bccsplat_writer_get_error(s.writer(s.options()).get(), 0, -1, &e);
       }},
      {"errors past the last", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto o = s.options();
         o.measure = BCCSPLAT_MEASURE_ALL;
         const Writer w = s.finished(o);
         auto e = sized<bccsplat_error_report>();
         EXPECT_OK(bccsplat_writer_get_error(w.get(), 0, 7, &e));
         EXPECT_EQ(bccsplat_writer_get_error(w.get(), 1, 0, &e), BCCSPLAT_ERROR_NOT_FOUND);
         return bccsplat_writer_get_error(w.get(), 0, 8, &e);
       }},
      {"joining no file", BCCSPLAT_ERROR_FILE_NOT_FOUND,
       [](Scene& s) {
         const std::string no = s.folder.file("no.bcc4");
         const char* parts[] = {no.c_str()};
         return bccsplat_join_parts(s.device.get(), 1, parts, s.folder.file("x.bcc4").c_str(), nullptr,
                                    nullptr);
       }},
      {"joining what is no part", BCCSPLAT_ERROR_INVALID_ARGUMENT,
       [](Scene& s) {
         const char* parts[] = {s.path.c_str()};
         return bccsplat_join_parts(s.device.get(), 1, parts, s.folder.file("x.bcc4").c_str(), nullptr,
                                    nullptr);
       }},
  });
}

TEST(Statuses, OfOpening) {
  expect_rows({
      {"no file", BCCSPLAT_ERROR_FILE_NOT_FOUND, [](Scene& s) { return s.open_at(s.folder.file("no")); }},
      {"a folder", BCCSPLAT_ERROR_IO, [](Scene& s) { return s.open_at(s.folder.path().string()); }},
      {"kernel", BCCSPLAT_ERROR_NOT_FOUND, [](Scene& s) { return s.open_at(s.path, "none such"); }},
      {"another format", BCCSPLAT_ERROR_NOT_BCC4,
       [](Scene& s) { return s.open_spoilt([](std::vector<char>& b) { b[0] = 'x'; }); }},
      {"cut short", BCCSPLAT_ERROR_TRUNCATED,
       [](Scene& s) { return s.open_spoilt([](std::vector<char>& b) { b.resize(b.size() - 100); }); }},
      {"a root that does not check out", BCCSPLAT_ERROR_CHECKSUM_MISMATCH,
       [](Scene& s) { return s.open_spoilt([](std::vector<char>& b) { b[64 + 20] ^= 1; }); }},
      {"more sites than a device allows", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) {
         auto o = sized<bccsplat_device_options>();
         o.max_sites = 100;
         bccsplat_device* d = nullptr;
         EXPECT_OK(bccsplat_device_create(&o, &d));
         const Device small(d);
         bccsplat_volume* v = nullptr;
         return bccsplat_volume_open_file(d, s.path.c_str(), nullptr, &v);
       }},
      {"a budget too small", BCCSPLAT_ERROR_MEMORY_BUDGET,
       [](Scene& s) {
         const Device small = make_device(1, 1000);
         bccsplat_volume* v = nullptr;
         const bccsplat_status status = bccsplat_volume_open_file(small.get(), s.path.c_str(), nullptr, &v);
         const Volume volume(v);
         if (status != BCCSPLAT_OK) return status;
         bccsplat_slice* slice = nullptr;
         return bccsplat_slice_create(v, &now, nullptr, &slice);
       }},
  });
}

// Wherever a file is damaged, what a call says of it names the file: a host may have many.
TEST(Statuses, DamageNamesTheFile) {
  const Scene scene;
  const std::vector<char> whole = file_bytes(scene.path);
  const std::string path = scene.folder.file("damaged.bcc4");
  int failed = 0;
  for (size_t at = 0; at < whole.size(); at += 61) {
    std::vector<char> bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    std::ofstream(path, std::ios::binary).write(bytes.data(), bytes.size());
    bccsplat_volume* v = nullptr;
    bccsplat_status status = bccsplat_volume_open_file(scene.device.get(), path.c_str(), nullptr, &v);
    const Volume volume(v);
    bccsplat_slice* s = nullptr;
    if (status == BCCSPLAT_OK) status = bccsplat_slice_create(v, &now, nullptr, &s);
    const Slice slice(s);
    if (status == BCCSPLAT_OK) continue;
    ++failed;
    EXPECT_NE(std::string(bccsplat_last_error()).find(path), std::string::npos) << bccsplat_last_error();
  }
  EXPECT_GT(failed, 10);
}

TEST(Statuses, OfVolumes) {
  static const double inside[4] = {4, 4, 4, 2}, outside[4] = {4, 4, 400, 2};
  static float value = 0;
  expect_rows({
      {"level", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto i = sized<bccsplat_level_info>();
         return bccsplat_volume_get_level_info(s.volume.get(), 1, &i);
       }},
      {"channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto i = sized<bccsplat_channel_info>();
         return bccsplat_volume_get_channel_info(s.volume.get(), 1, &i);
       }},
      {"channel by name", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         uint32_t c = 0;
         return bccsplat_volume_find_channel(s.volume.get(), "none", &c);
       }},
      {"ranges of a channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return bccsplat_volume_get_frame_ranges(s.volume.get(), 1, nullptr, 0, nullptr); }},
      {"time", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) {
         double index = 0;
         EXPECT_EQ(bccsplat_volume_index_to_time(s.volume.get(), 7.5, &index), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
         return bccsplat_volume_time_to_index(s.volume.get(), -1, &index);
       }},
      {"attribute", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         const char *key = nullptr, *text = nullptr;
         EXPECT_EQ(bccsplat_volume_get_attribute(s.volume.get(), 99, &key, &text), BCCSPLAT_ERROR_NOT_FOUND);
         return bccsplat_volume_find_attribute(s.volume.get(), "none", &text);
       }},
      {"source", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return bccsplat_volume_get_source(s.volume.get(), 0, nullptr, nullptr, nullptr); }},
      {"look", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto l = sized<bccsplat_look>();
         return bccsplat_volume_get_look(s.volume.get(), 1, 0, 0, &l);
       }},
      {"a point outside", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) { return bccsplat_volume_evaluate(s.volume.get(), 1, outside, &value, nullptr); }},
      {"a point of no channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         return bccsplat_volume_evaluate_channel(s.volume.get(), 1, 1, inside, &value, nullptr);
       }},
      {"a point by a kernel that reaches too far", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = s.options();
         o.lattice = BCCSPLAT_LATTICE_CC;
         (void)s.finished(o);
         bccsplat_status status = BCCSPLAT_OK;
         for (uint32_t i = 0; status == BCCSPLAT_OK && bccsplat_kernel_name(i); ++i)
           status = bccsplat_volume_evaluate(
               open(s.device, s.folder.file("new.bcc4"), bccsplat_kernel_name(i)).get(), 1, inside, &value,
               nullptr);
         return status;
       }},
      {"a point in a hole", BCCSPLAT_ERROR_HOLE,
       [](Scene& s) {
         NoiseSeries noise;
         noise.nx = noise.ny = noise.nz = 20, noise.holes = true;
         const std::vector<char> bytes = written(s.device, noise, noise.options());
         bccsplat_volume* v = nullptr;
         EXPECT_OK(bccsplat_volume_open_memory(s.device.get(), bytes.data(), bytes.size(), nullptr, &v));
         const Volume volume(v);
         const double at[4] = {0, 0, 0, 2};
         return bccsplat_volume_evaluate(v, 1, at, &value, nullptr);
       }},
  });
}
} // namespace
} // namespace host::statuses
