// SPDX-License-Identifier: Apache-2.0
// The smallest, oddest and largest things that may be asked for.
#include "tests/stability/stability.h"

namespace host {
namespace {

TEST(StabilitySizes, FromOneVoxelAndOneFrameUp) {
  const Device device = make_device();
  // The temporal kernel reaches over 4 layers: series shorter than that mirror into themselves.
  Bound bound("constant on 1 to 5 voxels, 1 to 6 frames, relative", 1e-6);
  for (const uint32_t n : {1u, 2u, 3u, 5u})
    for (const uint32_t frames : {1u, 2u, 3u, 4u, 5u, 6u}) {
      const Series s{
          .nx = n, .ny = n, .nz = n, .nt = frames, .field = [](double, double, double, double) { return 7; }};
      const Stored stored = store(device, s);
      for (const float v : values_at(stored.volume, random_points(s, 50)))
        bound.add(static_cast<double>(v) / 7 - 1);
      const Slice slice = cut_time(stored.volume, 0.5 * (frames - 1));
      for (const float v : grid_of(slice)) bound.add(static_cast<double>(v) / 7 - 1);
      EXPECT_TRUE(all_finite(picture(device, slice, {.ramp = {0, 10, 0.5, 1}})));
    }
}

TEST(StabilitySizes, FlatLinearAndPrimeShapes) {
  const Device device = make_device();
  for (const auto& [nx, ny, nz] :
       {std::array{31u, 1u, 1u}, std::array{1u, 29u, 13u}, std::array{23u, 2u, 17u}}) {
    Series s{.nx = nx, .ny = ny, .nz = nz, .nt = 7};
    s.field = [=](double x, double y, double z, double) {
      return 3 + std::cos(std::numbers::pi * x / std::max(1u, nx - 1)) +
             std::cos(std::numbers::pi * y / std::max(1u, ny - 1)) +
             std::cos(std::numbers::pi * z / std::max(1u, nz - 1));
    };
    // Two samples carry half a wave: no band limit could hold that; only long axes are held to the field.
    const bool smooth = ny != 2;
    const Stored stored = store(device, s);
    const std::vector<double> points = random_points(s, 200);
    const std::vector<float> got = values_at(stored.volume, points);
    ASSERT_TRUE(all_finite(got));
    if (!smooth) continue;
    Bound bound("waves on " + shown(nx) + " x " + shown(ny) + " x " + shown(nz) + ", values 0 to 6", 0.03);
    for (size_t i = 0; i < got.size(); ++i)
      bound.add(got[i] - s.field(points[4 * i], points[4 * i + 1], points[4 * i + 2], 0));
  }
}

TEST(StabilitySizes, OnePixelSeesWhatTheMiddleOfThreeSees) {
  const Device device = make_device();
  const Series s;
  const Stored stored = store(device, s);
  const Slice slice = cut_time(stored.volume, 3);
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 20, 30, 1, 1, &camera));
  const std::vector<float> one =
      picture(device, slice, {.width = 1, .height = 1, .ramp = {0, 100, 0.2, 1}, .camera = &camera});
  camera.ortho_height *= 3;
  const std::vector<float> three =
      picture(device, slice, {.width = 3, .height = 3, .ramp = {0, 100, 0.2, 1}, .camera = &camera});
  ASSERT_EQ(one.size(), 4u);
  Bound bound("one pixel against the middle of three by three", 1e-5);
  for (size_t c = 0; c < 4; ++c) bound.add(static_cast<double>(one[c]) - three[16 + c]);
  EXPECT_GT(one[3], 0.1f);
}

TEST(StabilitySizes, ASixteenThousandPixelImageStaysWithinItsBudget) {
  // 16384 x 1024 pixels of four floats are 256 MiB; what drawing needs beside them is small.
  const uint64_t image = uint64_t{16384} * 1024 * 16;
  const Device device = make_device(2, image + (uint64_t{96} << 20));
  const Series s{.nx = 12, .ny = 12, .nz = 12, .nt = 3};
  const Stored stored = store(device, s);
  const Slice slice = cut_time(stored.volume, 1);
  const std::vector<float> pixels =
      picture(device, slice, {.width = 16384, .height = 1024, .ramp = {0, 100, 0.5, 1}});
  EXPECT_TRUE(all_finite(pixels));
  EXPECT_GT(*std::max_element(pixels.begin(), pixels.end()), 0.0f);
  auto info = sized<bccsplat_device_info>();
  ASSERT_OK(bccsplat_device_get_info(device.get(), &info));
  EXPECT_LE(info.memory_peak, info.memory_budget);
}

TEST(StabilitySizes, AFieldOfNothingButAirIsStillAField) {
  const Device device = make_device();
  const Series s{
      .nx = 10, .ny = 9, .nz = 8, .nt = 4, .field = [](double, double, double, double) { return 5; }};
  auto channel = sized<bccsplat_channel_options>();
  channel.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
  channel.air = 5;
  bccsplat_writer_options o = options_of(s);
  o.channels = &channel, o.channel_count = 1;
  const Stored stored = store(device, s, o);
  auto info = sized<bccsplat_channel_info>();
  ASSERT_OK(bccsplat_volume_get_channel_info(stored.volume.get(), 0, &info));
  EXPECT_EQ(info.sites_kept, 0u);
  for (const float v : values_at(stored.volume, random_points(s, 50))) ASSERT_EQ(v, 5);
  const Slice slice = cut_time(stored.volume, 1.5);
  for (const float v : grid_of(slice)) ASSERT_EQ(v, 5);
  for (const float v : picture(device, slice, {.ramp = {5, 6, 0.5, 1}})) ASSERT_EQ(v, 0);
}

} // namespace
} // namespace host
