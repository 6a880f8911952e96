// SPDX-License-Identifier: Apache-2.0
// Axes whose samples are unevenly spaced: coordinates come back, the samples stay those of the source, and
// the world is where the coordinates say.
#include <array>
#include <limits>
#include <vector>

#include "support.h"

namespace host::uneven_axes {
namespace {

const std::vector<double> depths{0, 10, 20, 30, 50, 75, 100, 125, 150, 200, 250, 300, 400, 500, 700, 1000};
const std::vector<double> latitudes{-71, -66, -60, -52, -43, -31, -17, 0, 17, 31, 43, 52};

// A series over depth (uneven, down), latitude (uneven) and longitude; world z is above the surface.
struct Ocean {
  std::array<bccsplat_axis, 3> axes{};
  Series series;
  bccsplat_writer_options options;

  Ocean() {
    for (auto& a : axes) a = sized<bccsplat_axis>();
    axes[0].unit = "degrees_east";
    axes[1].count = latitudes.size(), axes[1].coordinates = latitudes.data(), axes[1].unit = "degrees_north";
    axes[2].count = depths.size(), axes[2].coordinates = depths.data(), axes[2].unit = "m";
    axes[2].flags = BCCSPLAT_AXIS_DOWN;
    series.nx = 18, series.ny = static_cast<uint32_t>(latitudes.size());
    series.nz = static_cast<uint32_t>(depths.size()), series.nt = 9;
    series.field = [](double x, double y, double z, double t) {
      return 20 * std::exp(-depths[static_cast<size_t>(z)] / 300) +
             3 * std::sin(0.4 * x + 0.3 * t) * std::cos(latitudes[static_cast<size_t>(y)] / 40);
    };
    options = options_of(series);
    options.axes = axes.data();
    const double step_y = (latitudes.back() - latitudes.front()) / (series.ny - 1.0);
    const double step_z = (depths.back() - depths.front()) / (series.nz - 1.0);
    const double affine[16] = {2, 0, 0, 30, 0, step_y, 0, latitudes.front(), 0, 0, -step_z, 0, 0, 0, 0, 1};
    std::copy(std::begin(affine), std::end(affine), options.affine);
  }
  Ocean(const Ocean&) = delete;
  Ocean& operator=(const Ocean&) = delete;

  [[nodiscard]] bccsplat_status write(const Device& device, const std::string& path) const {
    bccsplat_writer* made = nullptr;
    const bccsplat_status status = bccsplat_writer_create(device.get(), path.c_str(), &options, &made);
    const Writer writer(made);
    if (status != BCCSPLAT_OK) return status;
    EXPECT_OK(add_frames(writer.get(), series));
    return bccsplat_writer_finish(writer.get(), nullptr);
  }
  [[nodiscard]] std::array<double, 3> world(double x, size_t y, size_t z) const {
    return {30 + 2 * x, latitudes[y], -depths[z]};
  }
};

void expect_coordinates(const Volume& volume, uint32_t axis, const std::vector<double>& expected,
                        const std::string& unit, uint32_t flags) {
  auto a = sized<bccsplat_axis>();
  ASSERT_OK(bccsplat_volume_get_axis(volume.get(), axis, &a));
  EXPECT_EQ(std::vector<double>(a.coordinates, a.coordinates + a.count), expected);
  EXPECT_EQ(a.unit, unit);
  EXPECT_EQ(a.flags, flags);
}

void expect_ocean(const Volume& volume) {
  expect_coordinates(volume, 0, {}, "degrees_east", 0);
  expect_coordinates(volume, 1, latitudes, "degrees_north", 0);
  expect_coordinates(volume, 2, depths, "m", BCCSPLAT_AXIS_DOWN);
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_STREQ(info.spatial_unit, "");
}

TEST(UnevenAxes, CoordinatesComeBack) {
  const Device device = make_device();
  const Folder folder;
  Ocean ocean;
  ocean.options.spatial_unit = "km"; // of axes that name none
  ocean.axes[0].unit = nullptr;
  ASSERT_OK(ocean.write(device, folder.file("a.bcc4")));
  const Volume volume = open(device, folder.file("a.bcc4"));
  expect_coordinates(volume, 0, {}, "km", 0);
  expect_coordinates(volume, 2, depths, "m", BCCSPLAT_AXIS_DOWN);
  auto axis = sized<bccsplat_axis>();
  EXPECT_EQ(bccsplat_volume_get_axis(volume.get(), 3, &axis), BCCSPLAT_ERROR_NOT_FOUND);
}

TEST(UnevenAxes, OfAnEvenVolumeThereAreNone) {
  const Device device = make_device();
  const Folder folder;
  Ocean ocean;
  ocean.axes[1].count = ocean.axes[2].count = 0;
  ocean.options.spatial_unit = "m";
  ASSERT_OK(ocean.write(device, folder.file("a.bcc4")));
  const Volume volume = open(device, folder.file("a.bcc4"));
  for (uint32_t a = 0; a < 3; ++a) expect_coordinates(volume, a, {}, "", 0);
  auto info = sized<bccsplat_volume_info>();
  ASSERT_OK(bccsplat_volume_get_info(volume.get(), &info));
  EXPECT_STREQ(info.spatial_unit, "m");
}

TEST(UnevenAxes, SamplesAreThoseOfTheSource) {
  const Device device = make_device();
  const Folder folder;
  Ocean ocean;
  ocean.options.abs_error = 0.002;
  ASSERT_OK(ocean.write(device, folder.file("uneven.bcc4")));
  const Volume volume = open(device, folder.file("uneven.bcc4"));
  const Series& s = ocean.series;
  std::vector<double> indices, world;
  std::vector<float> expected;
  for (uint32_t t = 0; t < s.nt; ++t)
    for (uint32_t z = 0; z < s.nz; ++z)
      for (uint32_t y = 0; y < s.ny; ++y)
        for (uint32_t x = 0; x < s.nx; ++x) {
          const auto at = ocean.world(x, y, z);
          for (const double v : {double(x), double(y), double(z), double(t)}) indices.push_back(v);
          for (const double v : {at[0], at[1], at[2], double(t)}) world.push_back(v);
          expected.push_back(static_cast<float>(s.field(x, y, z, t)));
        }
  std::vector<float> by_index(expected.size()), by_world(expected.size());
  ASSERT_OK(
      bccsplat_volume_evaluate(volume.get(), expected.size(), indices.data(), by_index.data(), nullptr));
  ASSERT_OK(bccsplat_volume_evaluate_world(volume.get(), 0, expected.size(), world.data(), by_world.data(),
                                           nullptr, nullptr));
  for (size_t i = 0; i < expected.size(); ++i) {
    ASSERT_LE(std::fabs(by_index[i] - expected[i]), 0.002) << i;
    ASSERT_LE(std::fabs(by_world[i] - expected[i]), 0.002 + 1e-4) << i;
  }
}

TEST(UnevenAxes, PlacesGoToTheWorldAndBack) {
  const Device device = make_device();
  const Folder folder;
  const Ocean ocean;
  ASSERT_OK(ocean.write(device, folder.file("a.bcc4")));
  const Volume volume = open(device, folder.file("a.bcc4"));
  std::vector<double> index, back;
  for (double p = 0; p <= 1; p += 1.0 / 512) {
    index.push_back(17 * p);
    index.push_back(11 * p);
    index.push_back(15 * (1 - p));
  }
  const uint64_t n = index.size() / 3;
  std::vector<double> world(index.size());
  ASSERT_OK(bccsplat_volume_index_to_world(volume.get(), n, index.data(), world.data()));
  back = world;
  ASSERT_OK(bccsplat_volume_world_to_index(volume.get(), n, back.data(), back.data()));
  for (size_t i = 0; i < index.size(); ++i) EXPECT_NEAR(back[i], index[i], 1e-12 * 16) << i;
  for (size_t z = 0; z < depths.size(); ++z) {
    const double at[3] = {3, 5, double(z)};
    double w[3];
    ASSERT_OK(bccsplat_volume_index_to_world(volume.get(), 1, at, w));
    const auto expected = ocean.world(3, 5, z);
    for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(w[a], expected[a], 1e-10);
  }
}

TEST(UnevenAxes, GradientsAreThoseOfTheWorld) {
  const Device device = make_device();
  const Folder folder;
  const Ocean ocean;
  ASSERT_OK(ocean.write(device, folder.file("a.bcc4")));
  const Volume volume = open(device, folder.file("a.bcc4"));
  const std::array<double, 4> at{47.3, -20.6, -61.7, 3.4};
  float value = 0, gradient[4];
  ASSERT_OK(bccsplat_volume_evaluate_world(volume.get(), 0, 1, at.data(), &value, gradient, nullptr));
  const std::array<double, 4> step{0.02, 0.02, 0.2, 0.02};
  for (size_t a = 0; a < 4; ++a) {
    std::array<float, 2> ends{};
    for (size_t e = 0; e < 2; ++e) {
      auto p = at;
      p[a] += e == 0 ? -step[a] : step[a];
      ASSERT_OK(bccsplat_volume_evaluate_world(volume.get(), 0, 1, p.data(), &ends[e], nullptr, nullptr));
    }
    const double slope = (ends[1] - ends[0]) / (2 * step[a]);
    EXPECT_NEAR(gradient[a], slope, 0.01 * std::fabs(slope) + 1e-4) << a;
  }
}

TEST(UnevenAxes, OutsideIsToldByTheIndex) {
  const Device device = make_device();
  const Folder folder;
  const Ocean ocean;
  ASSERT_OK(ocean.write(device, folder.file("a.bcc4")));
  const Volume volume = open(device, folder.file("a.bcc4"));
  const double above[4] = {40, 0, 1, 0}; // the air
  float value = 0;
  EXPECT_EQ(bccsplat_volume_evaluate_world(volume.get(), 0, 1, above, &value, nullptr, nullptr),
            BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_NE(std::string(bccsplat_last_error()).find("along z"), std::string::npos) << bccsplat_last_error();
}

void expect_refused(const Device& device, const Ocean& ocean, bccsplat_status status, const char* text) {
  const Folder folder;
  EXPECT_EQ(ocean.write(device, folder.file("a.bcc4")), status) << text;
  EXPECT_NE(std::string(bccsplat_last_error()).find(text), std::string::npos) << bccsplat_last_error();
}

TEST(UnevenAxes, WhatPutsNoSampleAnywhereIsRefused) {
  const Device device = make_device();
  const auto with = [&](const std::vector<double>& at, bccsplat_status status, const char* text) {
    Ocean ocean;
    ocean.axes[2].coordinates = at.data(), ocean.axes[2].count = at.size();
    expect_refused(device, ocean, status, text);
  };
  auto changed = depths;
  changed.pop_back();
  with(changed, BCCSPLAT_ERROR_INVALID_ARGUMENT, "15 coordinates, the axis 16 samples");
  changed = depths, changed[4] = 30;
  with(changed, BCCSPLAT_ERROR_INVALID_ARGUMENT, "axis z: coordinate 30 of sample 4");
  changed = depths, changed[4] = std::numeric_limits<double>::quiet_NaN();
  with(changed, BCCSPLAT_ERROR_INVALID_ARGUMENT, "axes[2].coordinates");
  changed = depths, changed[0] = -1e29;
  with(changed, BCCSPLAT_ERROR_INVALID_ARGUMENT, "are one place");
  Ocean null;
  null.axes[2].coordinates = nullptr;
  expect_refused(device, null, BCCSPLAT_ERROR_INVALID_ARGUMENT, "axes[2].coordinates");
  Ocean flags;
  flags.axes[2].flags = 6;
  expect_refused(device, flags, BCCSPLAT_ERROR_INVALID_ARGUMENT, "axes[2].flags");
  Ocean periodic;
  periodic.options.periodic_axes = BCCSPLAT_PERIODIC_Y;
  expect_refused(device, periodic, BCCSPLAT_ERROR_UNSUPPORTED, "axis y is periodic");
  Ocean text;
  text.axes[0].unit = "\xff";
  expect_refused(device, text, BCCSPLAT_ERROR_INVALID_ARGUMENT, "axes[0].unit is not UTF-8");
}

TEST(UnevenAxes, SeriesThatGoOnKeepThemAndTakeNoOthers) {
  const Device device = make_device();
  const Folder folder;
  Ocean ocean;
  const std::string path = folder.file("a.bcc4");
  ocean.options.ends = BCCSPLAT_ENDS_MIRROR;
  ASSERT_OK(ocean.write(device, path));
  ocean.series.nt = 13, ocean.options.dims[3] = 13;
  ocean.options.partial = BCCSPLAT_PARTIAL_APPEND;
  auto others = depths;
  others[3] = 31;
  ocean.axes[2].coordinates = others.data();
  EXPECT_EQ(ocean.write(device, path), BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("its sample 3 along z is at 30"), std::string::npos)
      << bccsplat_last_error();
  ocean.axes[2].count = 0;
  EXPECT_EQ(ocean.write(device, path), BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("along z its samples are unevenly spaced"),
            std::string::npos)
      << bccsplat_last_error();
  ocean.axes[2].count = depths.size(), ocean.axes[2].coordinates = depths.data();
  ASSERT_OK(ocean.write(device, path));
  expect_ocean(open(device, path));
}

// Writes a part with the frames that it asks for.
void write_part(const Device& device, const Ocean& ocean, uint64_t first, uint64_t end,
                const std::string& path) {
  std::vector<double> times;
  for (uint32_t t = 0; t < ocean.series.nt; ++t) times.push_back(t);
  auto part = sized<bccsplat_series_part>();
  part.first = first, part.end = end, part.times = times.data();
  bccsplat_writer_options options = ocean.options;
  options.part = &part;
  const Writer writer = make_writer(device, path, options);
  uint64_t from = 0, to = 0;
  ASSERT_OK(bccsplat_writer_get_part_frames(writer.get(), &from, &to));
  Series some = ocean.series;
  some.times = {times.begin() + static_cast<std::ptrdiff_t>(from),
                times.begin() + static_cast<std::ptrdiff_t>(to)};
  some.nt = static_cast<uint32_t>(to - from);
  some.field = [&](double x, double y, double z, double t) {
    return ocean.series.field(x, y, z, t + static_cast<double>(from));
  };
  ASSERT_OK(add_frames(writer.get(), some));
  ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
}

TEST(UnevenAxes, PartsAreJoinedWithThemAndRefusedWithOthers) {
  const Device device = make_device();
  const Folder folder;
  Ocean ocean;
  ocean.series.nt = ocean.options.dims[3] = 24;
  write_part(device, ocean, 0, 12, folder.file("0.bcc4"));
  write_part(device, ocean, 12, 24, folder.file("1.bcc4"));
  auto others = depths;
  others[3] = 31;
  ocean.axes[2].coordinates = others.data();
  write_part(device, ocean, 12, 24, folder.file("x.bcc4"));
  const std::string a = folder.file("0.bcc4"), b = folder.file("1.bcc4"), x = folder.file("x.bcc4");
  const char* good[] = {a.c_str(), b.c_str()};
  const char* bad[] = {a.c_str(), x.c_str()};
  EXPECT_EQ(bccsplat_join_parts(device.get(), 2, bad, folder.file("bad.bcc4").c_str(), nullptr, nullptr),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("the coordinates along the axes differ"),
            std::string::npos)
      << bccsplat_last_error();
  ASSERT_OK(bccsplat_join_parts(device.get(), 2, good, folder.file("all.bcc4").c_str(), nullptr, nullptr));
  expect_ocean(open(device, folder.file("all.bcc4")));
}

TEST(UnevenAxes, UnfinishedWorkIsTakenUpWithTheSameAlone) {
  const Device device = make_device();
  const Folder folder;
  Ocean ocean;
  const std::string path = folder.file("a.bcc4");
  ocean.options.partial = BCCSPLAT_PARTIAL_KEEP;
  ocean.series.nt = ocean.options.dims[3] = 24;
  {
    const Writer writer = make_writer(device, path, ocean.options);
    Series some = ocean.series;
    some.nt = 20; // enough for slabs
    ASSERT_OK(add_frames(writer.get(), some));
  }
  ocean.options.partial = BCCSPLAT_PARTIAL_RESUME;
  auto others = depths;
  others[3] = 31;
  ocean.axes[2].coordinates = others.data();
  EXPECT_EQ(ocean.write(device, path), BCCSPLAT_ERROR_WRONG_STATE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("coordinates along z"), std::string::npos)
      << bccsplat_last_error();
  ocean.axes[2].coordinates = depths.data();
  ASSERT_OK(ocean.write(device, path));
  expect_ocean(open(device, path));
}

} // namespace
} // namespace host::uneven_axes
