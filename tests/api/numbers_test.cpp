// SPDX-License-Identifier: Apache-2.0
// Every number, count and text that a host hands in has a range in the header: beyond it the call refuses it,
// by the name of its field, and what was there before stays as it was.
#include <cfloat>
#include <limits>

#include "host_streams.h"

namespace host {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = HUGE_VAL;
constexpr double number = 1e30, value = FLT_MAX, view = 1e36, colour = 1e9; // the largest of each kind

// A field of a struct: which values the call that takes the struct refuses, and which it does not.
struct Field {
  const char* name;
  double* place;
  std::vector<double> refused, taken;
};
// Beside what none may be.
[[nodiscard]] std::vector<double> wrong(std::vector<double> more) {
  more.insert(more.end(), {nan, infinite, -infinite, 1e300, -1e300});
  return more;
}

// Sets each field to each value and makes the call, which leaves no handle behind.
template<class Call> void expect_ranges(const std::vector<Field>& fields, const Call& call) {
  EXPECT_EQ(call(), BCCSPLAT_OK) << bccsplat_last_error();
  for (const Field& f : fields) {
    const double before = *f.place;
    for (const double v : f.refused) {
      *f.place = v;
      EXPECT_EQ(call(), BCCSPLAT_ERROR_INVALID_ARGUMENT) << f.name << " = " << v;
      EXPECT_NE(std::string(bccsplat_last_error()).find(f.name), std::string::npos)
          << f.name << " = " << v << ": " << bccsplat_last_error();
    }
    for (const double v : f.taken) {
      *f.place = v;
      EXPECT_EQ(call(), BCCSPLAT_OK) << f.name << " = " << v << ": " << bccsplat_last_error();
    }
    *f.place = before;
  }
}

struct Scene {
  Folder folder;
  Device device = make_device();
  Volume volume;
  Scene() {
    (void)write_series(device, folder.file("s.bcc4"));
    volume = open(device, folder.file("s.bcc4"));
  }
  [[nodiscard]] Renderer renderer() const {
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    return Renderer(r);
  }
};

TEST(Numbers, OfWriters) {
  const Device device = make_device();
  Sink sink;
  const bccsplat_write_stream stream = sink.stream();
  auto channel = sized<bccsplat_channel_options>();
  channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR | BCCSPLAT_CHANNEL_SET_RANGE, channel.range[1] = 1;
  auto o = options_of({});
  o.channels = &channel, o.channel_count = 1;
  o.affine[0] = o.affine[5] = o.affine[10] = o.affine[15] = 1;
  const auto create = [&] {
    bccsplat_writer* w = nullptr;
    const bccsplat_status status = bccsplat_writer_create_stream(device.get(), &stream, &o, &w);
    bccsplat_writer_release(w);
    return status;
  };
  std::vector<Field> fields{
      {".air", &channel.air, wrong({4e38}), {-value, value}},
      {".air_threshold", &channel.air_threshold, wrong({-1, 4e38}), {value}},
      {".range", &channel.range[0], wrong({-4e38}), {-value}},
      {".range", &channel.range[1], wrong({4e38}), {value}},
      {".value_step", &channel.value_step, wrong({-1, 4e38}), {}},
      {".scale", &o.scale, wrong({-1, 65537, 1e-300}), {0.5, 65536}},
      {".time_scale", &o.time_scale, wrong({-1, 65537, 1e-300}), {0.5, 65536}},
      {".abs_error", &o.abs_error, wrong({-1, 4e38}), {value}},
      {".psnr", &o.psnr, wrong({-1, 1001}), {1000}},
      {".affine", &o.affine[3], wrong({2 * number}), {-number, number}},
      {".affine", &o.affine[0], wrong({2 * number, 1e-100}), {-number, number}},
  };
  for (double& scale : o.scales) fields.push_back({".scales", &scale, wrong({-1, 65537, 1e-300}), {0.5}});
  expect_ranges(fields, create);
  double times[] = {0, 1, 2, 3, 4, 5, 6, 7};
  auto part = sized<bccsplat_series_part>();
  part.end = 4, part.times = times;
  o.part = &part;
  expect_ranges({{".times", &times[7], wrong({2 * number}), {number}}}, create);
}

TEST(Numbers, OfTimes) {
  const Device device = make_device();
  Sink sink;
  const bccsplat_write_stream stream = sink.stream();
  const auto o = options_of({});
  bccsplat_writer* w = nullptr;
  ASSERT_OK(bccsplat_writer_create_stream(device.get(), &stream, &o, &w));
  const Writer writer(w);
  double first = 0, step = 1, time = 0;
  expect_ranges({{"first", &first, wrong({2 * number}), {-number, number}},
                 {"step", &step, wrong({0, -1, 2 * number}), {number}}},
                [&] { return bccsplat_writer_set_times(w, first, step); });
  for (const double v : wrong({2 * number}))
    EXPECT_EQ(bccsplat_writer_add_frame(w, 0, v, nullptr, 0), BCCSPLAT_ERROR_INVALID_ARGUMENT) << v;
  EXPECT_OK(bccsplat_writer_add_frame(w, 0, time, nullptr, 0));
  EXPECT_EQ(bccsplat_writer_set_times(w, 0, 1), BCCSPLAT_ERROR_WRONG_STATE); // frames have their own
}

TEST(Numbers, OfSlices) {
  const Scene scene;
  auto o = sized<bccsplat_slice_options>();
  auto h = plane_of(0, 0, 0, 1, -3);
  bccsplat_hyperplane* plane = &h;
  const auto cut = [&] {
    bccsplat_slice* s = nullptr;
    const bccsplat_status status = bccsplat_slice_create(scene.volume.get(), plane, &o, &s);
    bccsplat_slice_release(s);
    const bccsplat_status ranges =
        bccsplat_volume_get_ranges(scene.volume.get(), plane, &o, 0, nullptr, 0, nullptr);
    EXPECT_EQ(ranges, status);
    return status;
  };
  expect_ranges({{".interval", &o.interval[0], wrong({-2 * number}), {-number}},
                 {".interval", &o.interval[1], wrong({2 * number}), {number}},
                 {".spacing", &o.spacing, wrong({-1, 21, 1000, 1e-300}), {0.5, 20}},
                 {".time_length", &o.time_length, wrong({-1, 2 * number, 1e-300}), {number}},
                 {".thickness", &o.thickness, wrong({-1, 2 * number}), {number}}},
                cut);
  double box[6] = {1, 1, 1, 9, 9, 9};
  o.box = box;
  expect_ranges(
      {{".box", &box[0], wrong({-2 * number}), {-number}}, {".box", &box[5], wrong({2 * number}), {number}}},
      cut);
  o.box = nullptr;
  h.e = -3;
  for (const auto& [name, place] : {std::pair{".a", &h.a}, {".b", &h.b}, {".c", &h.c}, {".d", &h.d}})
    expect_ranges({{name, place, {nan, infinite, -infinite}, {2 * number, 1e300}}}, cut);
  h = plane_of(1, 1, 0, 1, -10);
  expect_ranges({{"hyperplane", &h.e, wrong({2 * number}), {number}}}, cut);
  h.reserved = 1;
  EXPECT_EQ(cut(), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  double point[4] = {1, 1, 1, 1}, basis[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1};
  plane = nullptr, o.point = point, o.basis = basis;
  expect_ranges(
      {{".point", &point[0], wrong({2 * number}), {}}, {".basis", &basis[0], wrong({2 * number}), {9}}}, cut);
}

TEST(Numbers, OfGrids) {
  const Scene scene;
  const Slice slice = cut_time(scene.volume, 3);
  auto g = sized<bccsplat_grid>();
  for (size_t a = 0; a < 3; ++a) g.step[a] = 1, g.dims[a] = 2;
  float values[8];
  std::vector<Field> fields;
  for (double& v : g.origin) fields.push_back({".origin", &v, wrong({2 * number}), {-number, number}});
  for (double& v : g.step) fields.push_back({".step", &v, wrong({2 * number}), {-number, 0, number}});
  const auto sample = [&] { return bccsplat_slice_sample_grid(slice.get(), &g, values); };
  expect_ranges(fields, sample);
  g.dims[0] = g.dims[1] = g.dims[2] = INT32_MAX;
  EXPECT_EQ(sample(), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find(".dims"), std::string::npos) << bccsplat_last_error();
}

TEST(Numbers, OfCameras) {
  const Scene scene;
  const Renderer renderer = scene.renderer();
  auto c = sized<bccsplat_camera>();
  c.position[2] = -9, c.up[1] = 1, c.ortho_height = 10, c.fovy_degrees = 30;
  const auto set = [&] { return bccsplat_renderer_set_camera(renderer.get(), &c); };
  std::vector<Field> fields;
  for (double* v : {&c.position[0], &c.target[0], &c.up[0]})
    fields.push_back({v == &c.up[0]       ? ".up"
                      : v == &c.target[0] ? ".target"
                                          : ".position",
                      v,
                      wrong({2 * view}),
                      {}});
  fields.push_back({".ortho_height", &c.ortho_height, wrong({0, -1, 2 * view}), {view}});
  expect_ranges(fields, set);
  c.projection = BCCSPLAT_PROJECTION_PERSPECTIVE;
  expect_ranges({{".fovy_degrees", &c.fovy_degrees, wrong({0, -1, 180, 171, 9e-4}), {1e-3, 170}}}, set);
  const Slice slice = cut_time(scene.volume, 3);
  double x = 0, y = 0;
  expect_ranges(
      {{"rotate_x_degrees", &x, wrong({2e6}), {1e6}}, {"rotate_y_degrees", &y, wrong({2e6}), {-1e6}}},
      [&] { return bccsplat_slice_fit_camera(slice.get(), 0, x, y, 8, 8, &c); });
}

TEST(Numbers, OfTransferFunctionsAndTrails) {
  const Scene scene;
  const Renderer renderer = scene.renderer();
  double colors[8] = {0, 1, 1, 1, 1, 1, 1, 1}, opacities[4] = {0, 0, 1, 1};
  auto f = sized<bccsplat_transfer_function>();
  f.colors = colors, f.opacities = opacities, f.color_count = f.opacity_count = 2;
  const std::vector<Field> fields{
      {"colors: a value", &colors[0], wrong({-4e38}), {-value}},
      {"colour", &colors[1], wrong({-1, 2 * colour}), {colour}},
      {"opacities: a value", &opacities[2], wrong({4e38}), {value}},
      {"opacity", &opacities[3], wrong({-1, 1.5}), {0.5}},
      {"unit_distance", &f.unit_distance, wrong({-1, 2e30, 0.5e-30}), {1e30, 1e-30}},
  };
  expect_ranges(fields, [&] { return bccsplat_renderer_set_transfer_function(renderer.get(), &f); });
  double tint[3] = {1, 1, 1};
  auto t = sized<bccsplat_trail>();
  t.interval[0] = -2, t.colors = tint, t.transfer_function = &f;
  const auto set_trail = [&] { return bccsplat_renderer_set_trail(renderer.get(), &t); };
  expect_ranges(fields, set_trail);
  expect_ranges({{".interval", &t.interval[0], wrong({-2 * number}), {-number}},
                 {".interval", &t.interval[1], wrong({2 * number}), {number}},
                 {".colors", &tint[1], wrong({-1, 2 * colour}), {colour}}},
                set_trail);
}

TEST(Numbers, OfLights) {
  const Scene scene;
  const Renderer renderer = scene.renderer();
  const Slice slice = cut_time(scene.volume, 3);
  ASSERT_OK(bccsplat_renderer_set_slice(renderer.get(), slice.get()));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(scene.device.get(), 24, 24, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  bccsplat_light light{{0, 0, -1}, {1, 1, 1}};
  auto l = sized<bccsplat_lights>();
  l.count = 1, l.lights = &light, l.ambient = 0.3, l.diffuse = 0.7, l.specular = 0.2, l.shininess = 20;
  expect_ranges({{".direction", &light.direction[2], wrong({2 * number, 1e-40}), {number, 1e-30, 0}},
                 {".color", &light.color[1], wrong({-1, 2 * colour}), {colour}},
                 {".ambient", &l.ambient, wrong({-1, 2 * colour}), {colour}},
                 {".diffuse", &l.diffuse, wrong({-1, 2 * colour}), {colour}},
                 {".specular", &l.specular, wrong({-1, 2 * colour}), {colour}},
                 {".shininess", &l.shininess, wrong({-1, 2e6}), {1e6}}},
                [&] { return bccsplat_renderer_set_lights(renderer.get(), &l); });
  // All of them at their largest: a picture of numbers.
  for (double& c : light.color) c = colour;
  l.ambient = l.diffuse = l.specular = colour;
  ASSERT_OK(bccsplat_renderer_set_lights(renderer.get(), &l));
  ASSERT_OK(bccsplat_renderer_render(renderer.get(), f));
  auto plane = sized<bccsplat_plane>();
  ASSERT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
  float most = 0;
  for (size_t i = 0; i < 24 * 24 * 4; ++i) {
    ASSERT_TRUE(std::isfinite(plane.pixels[i])) << i;
    most = std::max(most, plane.pixels[i]);
  }
  EXPECT_GT(most, 1e9f);
}

TEST(Numbers, OfPictures) {
  const Scene scene;
  const Renderer renderer = scene.renderer();
  auto o = sized<bccsplat_render_options>();
  o.set_mask = BCCSPLAT_RENDER_SET_ISO | BCCSPLAT_RENDER_SET_GRADIENT_NOISE;
  expect_ranges({{".sheet_step", &o.sheet_step, wrong({-1, 1e-4, 17}), {1e-3, 16}},
                 {".iso_value", &o.iso_value, wrong({4e38}), {-value, value}},
                 {".opacity_stop", &o.opacity_stop, wrong({-1, 1e-300, 0.0009, 1.5}), {0, 0.001, 1}},
                 {".deep_tolerance", &o.deep_tolerance, wrong({-1, 1.5}), {1}},
                 {".gradient_noise", &o.gradient_noise, wrong({-1, 4e38}), {value}}},
                [&] { return bccsplat_renderer_set_options(renderer.get(), &o); });
  // Of several surfaces the one is named that has it, and one that is not there is checked like others.
  bccsplat_iso_surface surfaces[2]{};
  o.mode = BCCSPLAT_MODE_ISOSURFACE, o.surfaces = surfaces, o.surface_count = 2;
  surfaces[1].use_color = 1;
  expect_ranges({{"surfaces[1].value", &surfaces[1].value, wrong({4e38}), {-value, value}},
                 {"surfaces[1].opacity", &surfaces[1].opacity, wrong({-0.1, 1.1}), {0, 1}},
                 {"surfaces[1].color", &surfaces[1].color[2], wrong({-1, 2e9}), {0, 1e9}}},
                [&] { return bccsplat_renderer_set_options(renderer.get(), &o); });
  surfaces[0].reserved = 1;
  EXPECT_EQ(bccsplat_renderer_set_options(renderer.get(), &o), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("surfaces[0].reserved"), std::string::npos);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(scene.device.get(), 4, 4, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  auto image = sized<bccsplat_image_options>();
  image.use_background = 1;
  std::vector<Field> fields{
      {".exposure_seconds", &image.exposure_seconds, wrong({-1, 2 * number}), {number}}};
  const auto save = [&](int32_t format) {
    return bccsplat_frame_save_memory(f, format, &image, nullptr, 0, nullptr);
  };
  expect_ranges(fields, [&] { return save(BCCSPLAT_IMAGE_EXR); });
  fields.clear();
  for (double& v : image.background) fields.push_back({".background", &v, wrong({-1, 2 * colour}), {colour}});
  expect_ranges(fields, [&] { return save(BCCSPLAT_IMAGE_PNG); });
}

// The largest voxels and the smallest look as others do.
TEST(Numbers, VoxelsOfAnySizeAreDrawn) {
  const Device device = make_device();
  std::vector<std::vector<float>> pictures;
  for (const double size : {1.0, number, 1e-30}) {
    Sink sink;
    const bccsplat_write_stream stream = sink.stream();
    auto o = options_of({});
    o.affine[0] = o.affine[5] = o.affine[10] = size, o.affine[15] = 1;
    bccsplat_writer* w = nullptr;
    ASSERT_OK(bccsplat_writer_create_stream(device.get(), &stream, &o, &w));
    {
      const Writer writer(w);
      ASSERT_OK(add_frames(w, {}));
      ASSERT_OK(bccsplat_writer_finish(w, nullptr));
    }
    bccsplat_volume* v = nullptr;
    ASSERT_OK(bccsplat_volume_open_memory(device.get(), sink.bytes.data(), sink.bytes.size(), nullptr, &v));
    const Volume volume(v);
    const Slice slice = cut_time(volume, 3);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    auto camera = sized<bccsplat_camera>();
    ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 20, 30, 32, 32, &camera));
    ASSERT_OK(bccsplat_renderer_set_camera(r, &camera));
    pictures.emplace_back(32 * 32 * 4);
    bccsplat_frame* f = nullptr;
    ASSERT_OK(bccsplat_frame_wrap(device.get(), 32, 32, pictures.back().data(), 0, &f));
    const Frame frame(f);
    ASSERT_OK(bccsplat_renderer_render(r, f));
  }
  double most = 0;
  for (size_t i = 0; i < pictures[0].size(); ++i) {
    EXPECT_NEAR(pictures[1][i], pictures[0][i], 2e-3) << i;
    EXPECT_NEAR(pictures[2][i], pictures[0][i], 2e-3) << i;
    most = std::max<double>(most, pictures[0][i]);
  }
  EXPECT_GT(most, 0.1);
}

TEST(Counts, ThatNoMemoryHolds) {
  const Scene scene;
  const Slice slice = cut_time(scene.volume, 3);
  const double at[4] = {1, 1, 1, 1};
  float out[4] = {-7, -7, -7, -7};
  constexpr auto refused = BCCSPLAT_ERROR_INVALID_ARGUMENT;
  for (const uint64_t n : {UINT64_MAX, UINT64_MAX - 5000, uint64_t{1} << 63, uint64_t{1} << 59}) {
    EXPECT_EQ(bccsplat_volume_evaluate(scene.volume.get(), n, at, out, nullptr), refused) << n;
    EXPECT_EQ(bccsplat_volume_evaluate_channel(scene.volume.get(), 0, n, at, out, nullptr), refused) << n;
    EXPECT_EQ(bccsplat_slice_evaluate(slice.get(), n, at, out, nullptr), refused) << n;
    bccsplat_volume* v = nullptr;
    EXPECT_EQ(bccsplat_volume_open_memory(scene.device.get(), at, n, nullptr, &v), refused) << n;
    EXPECT_EQ(bccsplat_join_parts(scene.device.get(), n, nullptr, "x", nullptr, nullptr), refused) << n;
  }
  EXPECT_EQ(out[0], -7);
  auto stream = sized<bccsplat_read_stream>();
  stream.read_at = FarFile::read_at, stream.size = UINT64_MAX;
  bccsplat_volume* v = nullptr;
  EXPECT_EQ(bccsplat_volume_open_stream(scene.device.get(), &stream, nullptr, &v), refused);
  // A capacity is as many as there are.
  uint64_t count = 0;
  EXPECT_OK(bccsplat_slice_get_points(slice.get(), UINT64_MAX, nullptr, nullptr, &count));
  std::vector<double> times(8);
  EXPECT_OK(bccsplat_volume_get_times(scene.volume.get(), times.data(), UINT64_MAX, &count));
}

TEST(Counts, RowsOfAFrameThatWrapAround) {
  const Device device = make_device();
  std::vector<float> pixels(8 * 8 * 4);
  bccsplat_frame* f = nullptr;
  for (const uint64_t row : {UINT64_MAX - 127, uint64_t{1} << 62, uint64_t{1} << 61, uint64_t{1} << 55})
    EXPECT_EQ(bccsplat_frame_wrap(device.get(), 8, 8, pixels.data(), row, &f),
              BCCSPLAT_ERROR_INVALID_ARGUMENT)
        << row;
  EXPECT_EQ(f, nullptr);
}

TEST(Texts, AreUtf8) {
  const Device device = make_device();
  Sink sink;
  const bccsplat_write_stream stream = sink.stream();
  auto channel = sized<bccsplat_channel_options>();
  auto o = options_of({});
  o.channels = &channel, o.channel_count = 1;
  constexpr auto refused = BCCSPLAT_ERROR_INVALID_ARGUMENT;
  for (const char** text : {&o.spatial_unit, &o.time_unit, &channel.name, &channel.unit}) {
    *text = "\xff";
    bccsplat_writer* w = nullptr;
    EXPECT_EQ(bccsplat_writer_create_stream(device.get(), &stream, &o, &w), refused);
    EXPECT_NE(std::string(bccsplat_last_error()).find("not UTF-8"), std::string::npos);
    *text = nullptr;
  }
  bccsplat_writer* w = nullptr;
  ASSERT_OK(bccsplat_writer_create_stream(device.get(), &stream, &o, &w));
  const Writer writer(w);
  EXPECT_EQ(bccsplat_writer_set_attribute(w, "k\xff", "v"), refused);
  EXPECT_EQ(bccsplat_writer_set_attribute(w, "k", "v\xff"), refused);
  EXPECT_OK(bccsplat_writer_set_attribute(w, "k", "v\xc3\xbc"));
  EXPECT_EQ(bccsplat_writer_add_source(w, "\xc3", 1, 0), refused);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 4, 4, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  auto image = sized<bccsplat_image_options>();
  image.comments = "\x80";
  EXPECT_EQ(bccsplat_frame_save_memory(f, BCCSPLAT_IMAGE_EXR, &image, nullptr, 0, nullptr), refused);
}

} // namespace
} // namespace host
