// SPDX-License-Identifier: Apache-2.0
// Conventions of the header that hosts took for others: what a short read means, which way matrices multiply,
// what an orthographic camera sees, what air is where nobody sets it.
#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "support.h"

using namespace host;

namespace {

struct Short {
  std::string bytes;
  uint64_t longest = 0; // read
};

int64_t read_short(void* user, uint64_t offset, void* out, uint64_t size) {
  const auto& s = *static_cast<const Short*>(user);
  size = std::min(size, s.longest);
  std::memcpy(out, s.bytes.data() + offset, size);
  return size;
}

TEST(Conventions, AShortReadEndsTheFile) {
  const Folder folder;
  const Device device = make_device(1);
  const std::string path = folder.file("s.bcc4");
  (void)write_series(device, path, Series{.nt = 2});
  std::ifstream file(path, std::ios::binary);
  Short source{.bytes = {std::istreambuf_iterator<char>(file), {}}};
  auto stream = sized<bccsplat_read_stream>();
  stream.size = source.bytes.size(), stream.read_at = read_short, stream.user = &source;
  bccsplat_volume* v = nullptr;
  source.longest = 100;
  EXPECT_EQ(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v), BCCSPLAT_ERROR_TRUNCATED);
  EXPECT_EQ(v, nullptr);
  source.longest = source.bytes.size();
  ASSERT_OK(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v));
  bccsplat_volume_release(v);
}

TEST(Conventions, MatricesTakeColumns) {
  const Folder folder;
  const Device device = make_device(1);
  const Series s{.nt = 2};
  auto o = options_of(s);
  const double affine[] = {2, 0, 0, 100, 0, 2, 0, 200, 0, 0, 2, 300, 0, 0, 0, 1};
  std::copy(std::begin(affine), std::end(affine), o.affine);
  const std::string path = folder.file("s.bcc4");
  {
    const Writer w = make_writer(device, path, o);
    ASSERT_OK(add_frames(w.get(), s));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }
  const Volume volume = open(device, path);
  const Slice slice = cut_time(volume, 0);
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 0, 0, 8, 8, &camera));
  EXPECT_NEAR(camera.target[0], 100 + (s.nx - 1), 1e-9); // twice the middle
  EXPECT_NEAR(camera.target[1], 200 + (s.ny - 1), 1e-9);
  EXPECT_NEAR(camera.target[2], 300 + (s.nz - 1), 1e-9);
}

TEST(Conventions, AnOrthographicCameraDrawsWhatLiesBehindIt) {
  const Folder folder;
  const Device device = make_device(1);
  Series s{.nt = 2};
  s.field = [](double, double, double, double) { return 100.0; };
  const std::string path = folder.file("s.bcc4");
  (void)write_series(device, path, s);
  const Volume volume = open(device, path);
  const Slice slice = cut_time(volume, 0);
  const double colors[] = {0, 1, 1, 1}, opacities[] = {0, 0.9};
  auto function = sized<bccsplat_transfer_function>();
  function.color_count = function.opacity_count = 1, function.colors = colors, function.opacities = opacities;
  constexpr uint32_t size = 16;
  for (const int32_t projection : {BCCSPLAT_PROJECTION_ORTHOGRAPHIC, BCCSPLAT_PROJECTION_PERSPECTIVE}) {
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    bccsplat_frame* f = nullptr;
    ASSERT_OK(
        bccsplat_frame_create(device.get(), size, size, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEPTH, &f));
    const Frame frame(f);
    auto camera = sized<bccsplat_camera>();
    camera.projection = projection, camera.ortho_height = 8, camera.fovy_degrees = 30;
    camera.position[0] = camera.target[0] = 9, camera.position[1] = camera.target[1] = 9;
    camera.position[2] = 9, camera.target[2] = 12, camera.up[1] = 1; // within the volume
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    ASSERT_OK(bccsplat_renderer_set_camera(r, &camera));
    ASSERT_OK(bccsplat_renderer_set_transfer_function(r, &function));
    ASSERT_OK(bccsplat_renderer_render(r, f));
    auto plane = sized<bccsplat_plane>();
    ASSERT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_DEPTH, &plane));
    const float nearest = *std::min_element(plane.pixels, plane.pixels + size * size);
    EXPECT_EQ(nearest < 0, projection == BCCSPLAT_PROJECTION_ORTHOGRAPHIC) << nearest;
    EXPECT_LT(nearest, 9) << "nothing drawn";
  }
}

TEST(Conventions, AirCountsOnlyWithItsBit) {
  const Folder folder;
  const Device device = make_device(1);
  const Series s{.nt = 2};
  for (const bool set : {false, true}) {
    auto channel = sized<bccsplat_channel_options>();
    channel.air = -1024;
    if (set) channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
    auto o = options_of(s);
    o.channels = &channel, o.channel_count = 1, o.overwrite = 1;
    const std::string path = folder.file("s.bcc4");
    const Writer w = make_writer(device, path, o);
    ASSERT_OK(add_frames(w.get(), s));
    ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
    auto info = sized<bccsplat_channel_info>();
    ASSERT_OK(bccsplat_volume_get_channel_info(open(device, path).get(), 0, &info));
    EXPECT_EQ(info.air, set ? -1024 : 0);
  }
}

// Air of doubles, and of integers of 32 bits, need not be a float.
TEST(Conventions, SamplesThatEqualAirAreAirThoughNoFloatIs) {
  const Folder folder;
  const Device device = make_device(1);
  const Series s;
  const auto written = [&](double air, bccsplat_type type, double abs_error) {
    auto channel = sized<bccsplat_channel_options>();
    channel.air = air, channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
    auto o = options_of(s);
    o.channels = &channel, o.channel_count = 1, o.overwrite = 1;
    o.abs_error = abs_error, o.measure = BCCSPLAT_MEASURE_ALL, o.levels = 1;
    const Writer w = make_writer(device, folder.file("air.bcc4"), o);
    const size_t n = size_t{s.nx} * s.ny * s.nz;
    std::vector<double> doubles(n);
    std::vector<int32_t> integers(n);
    for (uint32_t t = 0; t < s.nt; ++t) {
      for (size_t i = 0; i < n; ++i) {
        const auto x = static_cast<double>(i % s.nx), y = static_cast<double>(i / s.nx % s.ny),
                   z = static_cast<double>(i / s.nx / s.ny);
        const double over = std::round(blob(x, y, z, t));
        doubles[i] = over == 0 ? air : air + over;
        integers[i] = static_cast<int32_t>(doubles[i]);
      }
      auto box = sized<bccsplat_box>();
      box.type = type;
      box.data = type == BCCSPLAT_TYPE_F64 ? static_cast<const void*>(doubles.data()) : integers.data();
      box.dims[0] = s.nx, box.dims[1] = s.ny, box.dims[2] = s.nz;
      EXPECT_OK(bccsplat_writer_add_frame(w.get(), 0, t, &box, 1));
    }
    auto report = sized<bccsplat_writer_report>();
    EXPECT_OK(bccsplat_writer_finish(w.get(), &report));
    auto errors = sized<bccsplat_error_report>();
    EXPECT_OK(bccsplat_writer_get_error(w.get(), 0, -1, &errors));
    return std::pair(report, errors);
  };
  const auto expect_air = [&](double air, bccsplat_type type, double bound) {
    const auto [none, none_errors] = written(0, BCCSPLAT_TYPE_F64, bound);
    const auto [report, errors] = written(air, type, bound);
    EXPECT_LT(none.sites_kept, none.sites_total / 4 * 3);
    EXPECT_NEAR(static_cast<double>(report.sites_kept), static_cast<double>(none.sites_kept), 2) << air;
    EXPECT_EQ(errors.non_air_samples, none_errors.non_air_samples) << air;
    EXPECT_LE(errors.max_abs, none_errors.max_abs + 2e-7 * air) << air;
    EXPECT_LE(errors.max_abs, bound > 0 ? bound : 4) << air;
  };
  expect_air(273.15, BCCSPLAT_TYPE_F64, 0);
  expect_air(273.15, BCCSPLAT_TYPE_F64, 0.01);
  expect_air(16777217, BCCSPLAT_TYPE_I32, 0); // 2^24 + 1
}

// Data whose x runs to the left, with the matrix that says so, look as those do whose x runs to the right.
TEST(Conventions, PicturesOfPlanesOverTimeAreNoMirrorImages) {
  const Folder folder;
  const Device device = make_device(1);
  const auto picture = [&](bool to_the_left) {
    Series s;
    if (to_the_left)
      s.field = [&s](double x, double y, double z, double t) { return blob(s.nx - 1 - x, y, z, t); };
    auto o = options_of(s);
    const double affine[] = {
        to_the_left ? -1.0 : 1.0, 0, 0, to_the_left ? s.nx - 1.0 : 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    std::copy(std::begin(affine), std::end(affine), o.affine);
    const std::string path = folder.file(to_the_left ? "left.bcc4" : "right.bcc4");
    {
      const Writer w = make_writer(device, path, o);
      EXPECT_OK(add_frames(w.get(), s));
      EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    }
    const Volume volume = open(device, path);
    auto h = sized<bccsplat_hyperplane>();
    h.c = 1, h.e = -9; // x, y and t
    bccsplat_slice* cut = nullptr;
    EXPECT_OK(bccsplat_slice_create(volume.get(), &h, nullptr, &cut));
    const Slice slice(cut);
    constexpr uint32_t size = 48;
    auto camera = sized<bccsplat_camera>();
    EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 20, 30, size, size,
                                        &camera));
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device.get(), size, size, BCCSPLAT_FRAME_RGBA, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    EXPECT_OK(bccsplat_renderer_set_camera(r, &camera));
    EXPECT_OK(bccsplat_renderer_render(r, f));
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
    return std::vector<float>(plane.pixels, plane.pixels + 4 * size_t{size} * size);
  };
  const auto right = picture(false), left = picture(true);
  double largest = 0, opaque = 0;
  for (size_t i = 0; i < right.size(); ++i) {
    largest = larger(largest, std::fabs(double{right[i]} - left[i]));
    opaque = std::max(opaque, double{right[i]});
  }
  EXPECT_GT(opaque, 0.3);
  EXPECT_LT(largest, 0.08); // the lattice is no mirror image of itself
}

} // namespace
