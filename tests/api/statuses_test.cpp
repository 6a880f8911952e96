// SPDX-License-Identifier: Apache-2.0
// The statuses that the header names behind "Also:", call by call: each is provoked, has a text, and leaves
// no handle behind.
#include "host_streams.h"

namespace host {
namespace {

constexpr bccsplat_status kept = BCCSPLAT_OK;

// A finished series, a slice of it, and what else calls are made on.
struct Scene {
  Folder folder;
  Device device = make_device();
  Series series;
  std::string path = folder.file("whole.bcc4");
  Volume volume;
  Slice slice, oblique;
  Renderer renderer;
  Frame frame;

  Scene() {
    write_series(device, path, series);
    volume = open(device, path);
    slice = cut_time(volume, 2.5), oblique = cut(volume, 0.5, 0.3, 0.2, 1, -12);
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    renderer.reset(r);
    frame = make_frame(BCCSPLAT_FRAME_RGBA);
  }
  [[nodiscard]] Frame make_frame(uint32_t channels) const {
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device.get(), 16, 16, channels, &f));
    return Frame(f);
  }
  [[nodiscard]] bccsplat_writer_options options() const { return options_of(series); }
  [[nodiscard]] Writer writer(const bccsplat_writer_options& o, const std::string& name = "new.bcc4") const {
    return make_writer(device, folder.file(name), o);
  }
  bccsplat_status create(const std::string& at, const bccsplat_writer_options& o) const {
    bccsplat_writer* w = nullptr;
    const bccsplat_status status = bccsplat_writer_create(device.get(), at.c_str(), &o, &w);
    EXPECT_EQ(w != nullptr, status == BCCSPLAT_OK);
    const Writer writer(w);
    return status;
  }
  bccsplat_status open_at(const std::string& at, const char* kernel = nullptr) const {
    auto o = sized<bccsplat_volume_options>();
    o.kernel = kernel;
    bccsplat_volume* v = nullptr;
    const bccsplat_status status = bccsplat_volume_open_file(device.get(), at.c_str(), &o, &v);
    EXPECT_EQ(v != nullptr, status == BCCSPLAT_OK);
    const Volume volume(v);
    return status;
  }
  // The file with some of its bytes changed.
  bccsplat_status open_spoilt(const std::function<void(std::vector<char>&)>& spoil) const {
    std::vector<char> bytes = file_bytes(path);
    spoil(bytes);
    bccsplat_volume* v = nullptr;
    const bccsplat_status status =
        bccsplat_volume_open_memory(device.get(), bytes.data(), bytes.size(), nullptr, &v);
    const Volume volume(v);
    return status;
  }
  template<class Set> bccsplat_status cut_with(const bccsplat_hyperplane& plane, const Set& set) const {
    auto o = sized<bccsplat_slice_options>();
    set(o);
    bccsplat_slice* s = nullptr;
    const bccsplat_status status = bccsplat_slice_create(volume.get(), &plane, &o, &s);
    EXPECT_EQ(s != nullptr, status == BCCSPLAT_OK);
    const Slice slice(s);
    return status;
  }
  template<class Set> bccsplat_status recode_with(const Set& set) const {
    auto o = sized<bccsplat_recode_options>();
    set(o);
    return bccsplat_volume_recode(volume.get(), folder.file("anew.bcc4").c_str(), &o, nullptr);
  }
  template<class Set> bccsplat_status render_with(const Set& set, const Slice* of = nullptr) const {
    EXPECT_OK(bccsplat_renderer_set_slice(renderer.get(), (of ? *of : slice).get()));
    auto o = sized<bccsplat_render_options>();
    set(o);
    EXPECT_OK(bccsplat_renderer_set_options(renderer.get(), &o));
    return bccsplat_renderer_render(renderer.get(), frame.get());
  }
};

const auto nothing = [](auto&) {};
const auto now = plane_of(0, 0, 0, 1, -2.5), tilted = plane_of(0.5, 0.3, 0.2, 1, -12);

struct Row {
  const char* name;
  bccsplat_status status;
  std::function<bccsplat_status(Scene&)> call;
};

void expect_rows(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    Scene scene;
    EXPECT_EQ(row.call(scene), row.status) << bccsplat_last_error();
    if (row.status != kept) {
      EXPECT_STRNE(bccsplat_last_error(), "");
    }
  }
}

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
         o.dims[0] = o.dims[1] = o.dims[2] = 60000;
         return s.create(s.folder.file("x.bcc4"), o);
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
         bccsplat_writer* w = nullptr;
         bccsplat_status status = bccsplat_writer_create(s.device.get(), s.path.c_str(), &o, &w);
         const Writer writer(w);
         if (status == BCCSPLAT_OK) status = add_frames(w, s.series); // at the first frame at the latest
         return status;
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
         const Writer w = s.writer(s.options());
         EXPECT_OK(add_frames(w.get(), s.series));
         EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
         EXPECT_EQ(bccsplat_writer_add_source(w.get(), "x", 1, 1), BCCSPLAT_ERROR_WRONG_STATE);
         EXPECT_EQ(bccsplat_writer_finish(w.get(), nullptr), BCCSPLAT_ERROR_WRONG_STATE);
         return bccsplat_writer_set_attribute(w.get(), "a", "b");
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
         const Writer w = s.writer(o);
         EXPECT_OK(add_frames(w.get(), s.series));
         EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
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
       [](Scene& s) {
         return s.open_spoilt([](std::vector<char>& b) {
           for (const size_t root : {4096u, 8192u}) b[root + 20] ^= 1;
         });
       }},
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
      {"a point by a kernel of another lattice", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         return bccsplat_volume_evaluate(open(s.device, s.path, "exact").get(), 1, inside, &value, nullptr);
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
      {"recoding for no kernel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.recode_with([](auto& o) { o.kernel = "none such"; }); }},
      {"recoding to a kernel without coefficients", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         return s.recode_with([](auto& o) { o.store = BCCSPLAT_STORE_COEFFICIENTS, o.kernel = "paper"; });
       }},
      {"recoding onto a file", BCCSPLAT_ERROR_FILE_EXISTS,
       [](Scene& s) { return bccsplat_volume_recode(s.volume.get(), s.path.c_str(), nullptr, nullptr); }},
      {"recoding into a stream that fails", BCCSPLAT_ERROR_IO,
       [](Scene& s) {
         Sink sink;
         sink.fail_at = 0;
         const auto stream = sink.stream();
         return bccsplat_volume_recode_stream(s.volume.get(), &stream, nullptr, nullptr);
       }},
  });
}

TEST(Statuses, OfSlices) {
  static float value = 0;
  static const double far[3] = {500, 0, 0};
  expect_rows({
      {"channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.cut_with(now, [](auto& o) { o.channel = 1; }); }},
      {"kernel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.cut_with(now, [](auto& o) { o.kernel = "none such"; }); }},
      {"level", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.cut_with(now, [](auto& o) { o.level = 1; }); }},
      {"time", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) { return s.cut_with(plane_of(0, 0, 0, 1, -9), nothing); }},
      {"a box beside the samples", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) {
         static const double box[6] = {50, 0, 0, 60, 5, 5};
         return s.cut_with(now, [](auto& o) { o.box = box; });
       }},
      {"a box that ends before it begins", BCCSPLAT_ERROR_INVALID_ARGUMENT,
       [](Scene& s) {
         static const double box[6] = {5, 9, 5, 9, 5, 9};
         return s.cut_with(now, [](auto& o) { o.box = box; });
       }},
      {"an oblique one merged", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) { return s.cut_with(tilted, [](auto& o) { o.method = BCCSPLAT_METHOD_MERGED; }); }},
      {"an interval off the time axis", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) { return s.cut_with(tilted, [](auto& o) { o.interval[1] = 2; }); }},
      {"too many planes", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) { return s.cut_with(tilted, [](auto& o) { o.spacing = 1e-6; }); }},
      {"prefetch of an oblique one", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) { return bccsplat_volume_prefetch(s.volume.get(), &tilted, nullptr); }},
      {"ranges of no channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto o = sized<bccsplat_slice_options>();
         o.channel = 1;
         uint64_t count = 0;
         return bccsplat_volume_get_ranges(s.volume.get(), &now, &o, 0, nullptr, 0, &count);
       }},
      {"a point outside", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) { return bccsplat_slice_evaluate(s.slice.get(), 1, far, &value, nullptr); }},
      {"gradients of extracted points", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = sized<bccsplat_slice_options>();
         o.method = BCCSPLAT_METHOD_EXTRACTED;
         bccsplat_slice* made = nullptr;
         EXPECT_OK(bccsplat_slice_create(s.volume.get(), &now, &o, &made));
         const Slice slice(made);
         const double at[3] = {4, 4, 4};
         float gradient[3];
         EXPECT_EQ(s.render_with(nothing, &slice), BCCSPLAT_ERROR_UNSUPPORTED);
         return bccsplat_slice_evaluate(made, 1, at, &value, gradient);
       }},
      {"what a picture needs of an oblique slice", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto camera = sized<bccsplat_camera>();
         EXPECT_OK(bccsplat_slice_fit_camera(s.oblique.get(), 0, 20, 30, 16, 16, &camera));
         auto needs = sized<bccsplat_picture_needs>();
         return bccsplat_slice_get_picture_needs(s.oblique.get(), &camera, 16, 16, nullptr, &needs);
       }},
  });
}

// A box without extent along an axis can be sampled and shows nothing.
TEST(Statuses, OfFlatBoxes) {
  const Scene scene;
  const double box[6] = {6, 10, 9, 12, 10, 14};
  auto o = sized<bccsplat_slice_options>();
  o.box = box;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(scene.volume.get(), &now, &o, &made));
  const Slice flat(made);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(made, &info));
  EXPECT_EQ(info.dims[1], 1u);
  std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
  ASSERT_OK(bccsplat_slice_sample_grid(made, nullptr, values.data()));
  ASSERT_EQ(values.size(), 7u * 6);
  for (const float v : values) EXPECT_FALSE(std::isnan(v));
  const double at[3] = {8.5, 10, 10.5};
  float of_box = 0, whole = 1;
  ASSERT_OK(bccsplat_slice_evaluate(made, 1, at, &of_box, nullptr));
  ASSERT_OK(bccsplat_slice_evaluate(scene.slice.get(), 1, at, &whole, nullptr));
  EXPECT_EQ(of_box, whole);
  EXPECT_OK(scene.render_with(nothing, &flat));
  auto plane = sized<bccsplat_plane>();
  ASSERT_OK(bccsplat_frame_get_channel(scene.frame.get(), BCCSPLAT_FRAME_RGBA, &plane));
  for (size_t i = 0; i < 16 * 16; ++i) EXPECT_EQ(plane.pixels[4 * i + 3], 0);
}

TEST(Statuses, OfPictures) {
  expect_rows({
      {"no slice", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) { return bccsplat_renderer_render(s.renderer.get(), s.frame.get()); }},
      {"no picture yet", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         auto stats = sized<bccsplat_render_stats>();
         return bccsplat_renderer_get_stats(s.renderer.get(), &stats);
       }},
      {"a trail of an X-ray", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto trail = sized<bccsplat_trail>();
         trail.interval[0] = -2;
         EXPECT_OK(bccsplat_renderer_set_trail(s.renderer.get(), &trail));
         return s.render_with([](auto& o) { o.mode = BCCSPLAT_MODE_XRAY; });
       }},
      {"a deep reference", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         s.frame = s.make_frame(BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP);
         return s.render_with([](auto& o) { o.reference = 1; });
       }},
      {"another device's slice", BCCSPLAT_ERROR_INVALID_HANDLE,
       [](Scene& s) {
         const Device other = make_device();
         const Slice slice = cut_time(open(other, s.path), 1);
         return bccsplat_renderer_set_slice(s.renderer.get(), slice.get());
       }},
      {"fields of view", BCCSPLAT_ERROR_INVALID_ARGUMENT,
       [](Scene& s) {
         auto camera = sized<bccsplat_camera>();
         EXPECT_OK(bccsplat_slice_fit_camera(s.slice.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, 16, 16,
                                             &camera));
         for (const double angle : {0.001, 170.0}) {
           camera.fovy_degrees = angle;
           EXPECT_OK(bccsplat_renderer_set_camera(s.renderer.get(), &camera));
         }
         camera.fovy_degrees = 171;
         EXPECT_EQ(bccsplat_renderer_set_camera(s.renderer.get(), &camera), BCCSPLAT_ERROR_INVALID_ARGUMENT);
         camera.fovy_degrees = 0.0009;
         return bccsplat_renderer_set_camera(s.renderer.get(), &camera);
       }},
      {"no such plane", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto plane = sized<bccsplat_plane>();
         return bccsplat_frame_get_channel(s.frame.get(), BCCSPLAT_FRAME_DEPTH, &plane);
       }},
      {"no deep samples", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto deep = sized<bccsplat_deep>();
         return bccsplat_frame_get_deep(s.frame.get(), &deep);
       }},
      {"no deep samples yet", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         s.frame = s.make_frame(BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP);
         auto deep = sized<bccsplat_deep>();
         return bccsplat_frame_get_deep(s.frame.get(), &deep);
       }},
  });
}

TEST(Statuses, OfSaving) {
  {
    const Scene scene;
    const bccsplat_status status =
        bccsplat_frame_save_png(scene.frame.get(), scene.folder.file("a.png").c_str(), nullptr);
    if (status == BCCSPLAT_ERROR_MISSING_FEATURE) GTEST_SKIP() << "built without images";
    ASSERT_OK(status);
  }
  expect_rows({
      {"no folder", BCCSPLAT_ERROR_FILE_NOT_FOUND,
       [](Scene& s) {
         const std::string path = s.folder.file("no/a.png");
         EXPECT_EQ(bccsplat_frame_save_exr(s.frame.get(), path.c_str(), nullptr),
                   BCCSPLAT_ERROR_FILE_NOT_FOUND);
         return bccsplat_frame_save_png(s.frame.get(), path.c_str(), nullptr);
       }},
      {"a file that exists", BCCSPLAT_ERROR_FILE_EXISTS,
       [](Scene& s) {
         EXPECT_EQ(bccsplat_frame_save_exr(s.frame.get(), s.path.c_str(), nullptr),
                   BCCSPLAT_ERROR_FILE_EXISTS);
         return bccsplat_frame_save_png(s.frame.get(), s.path.c_str(), nullptr);
       }},
      {"flat pixels as deep ones", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         return bccsplat_frame_save_deep_exr(s.frame.get(), s.folder.file("a.exr").c_str(), nullptr);
       }},
      {"deep pixels before a render", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         s.frame = s.make_frame(BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP);
         return bccsplat_frame_save_deep_exr(s.frame.get(), s.folder.file("a.exr").c_str(), nullptr);
       }},
      {"a stream that fails", BCCSPLAT_ERROR_IO,
       [](Scene& s) {
         Sink sink;
         sink.fail_at = 0;
         const auto stream = sink.stream();
         return bccsplat_frame_save_stream(s.frame.get(), BCCSPLAT_IMAGE_PNG, &stream, nullptr);
       }},
  });
}

} // namespace
} // namespace host
