// SPDX-License-Identifier: Apache-2.0
// Labels that a host names as such: of any number and type, whole wherever they are looked up, and refused
// where they could not be.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support.h"

namespace host {
namespace {

constexpr std::array<float, 5> numbers{0, 2, 4, 1035, 0.25F};
double block(double x, double y, double z, double t) {
  return numbers[static_cast<size_t>((x + t) / 4 + y / 5 + z / 6) % numbers.size()];
}

class SaidLabels : public testing::Test {
 protected:
  SaidLabels() {
    channel.set_mask = BCCSPLAT_CHANNEL_LABELS;
    series.nx = 20, series.ny = 16, series.nz = 12, series.nt = 4;
    series.field = block;
    options = options_of(series);
    options.lattice = BCCSPLAT_LATTICE_CC;
    options.channels = &channel, options.channel_count = 1;
  }
  void write() {
    const Writer w = make_writer(device, folder.file("l.bcc4"), options);
    EXPECT_OK(add_frames(w.get(), series, 0));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    volume = open(device, folder.file("l.bcc4"));
  }
  [[nodiscard]] bccsplat_status created() const {
    bccsplat_writer* made = nullptr;
    const bccsplat_status status =
        bccsplat_writer_create(device.get(), folder.file("x.bcc4").c_str(), &options, &made);
    bccsplat_writer_release(made);
    return status;
  }
  [[nodiscard]] bool are_labels() const {
    auto info = sized<bccsplat_channel_info>();
    EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &info));
    return info.labels != 0;
  }
  [[nodiscard]] float value(std::array<double, 4> at) const {
    float found = 0;
    EXPECT_OK(bccsplat_volume_evaluate(volume.get(), 1, at.data(), &found, nullptr));
    return found;
  }

  Folder folder;
  Device device = make_device();
  Volume volume;
  Series series;
  bccsplat_channel_options channel = sized<bccsplat_channel_options>();
  bccsplat_writer_options options{};
};

TEST_F(SaidLabels, AreThoseOfTheNearestSample) {
  write();
  EXPECT_TRUE(are_labels());
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -1.5;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, nullptr, &made));
  const Slice slice(made);
  for (double x = 0.1; x < 19; x += 0.7)
    for (double y = 0.3; y < 15; y += 0.9) {
      const auto nearest = static_cast<float>(block(std::floor(x + 0.5), std::floor(y + 0.5), 5, 2));
      EXPECT_EQ(value({x, y, 5.2, 1.5}), nearest) << x << ' ' << y;
      const std::array<double, 3> uvw{x, y, 5.2};
      float found = 0;
      ASSERT_OK(bccsplat_slice_evaluate(made, 1, uvw.data(), &found, nullptr));
      EXPECT_EQ(found, nearest) << x << ' ' << y;
    }
}

TEST_F(SaidLabels, QuantitiesOfFewWholeNumbersAreBlended) {
  series.field = [](double x, double, double, double) { return x < 10 ? 3 : 7; };
  channel.source_type = channel.value_type = BCCSPLAT_TYPE_U8;
  channel.set_mask = 0;
  write();
  EXPECT_TRUE(are_labels()) << "by its values, where nobody says it";
  channel.set_mask = BCCSPLAT_CHANNEL_QUANTITIES, options.overwrite = 1;
  write();
  EXPECT_FALSE(are_labels());
  EXPECT_NEAR(value({9.5, 5, 5, 1}), 5, 0.1);
}

TEST_F(SaidLabels, WhatWouldBlendThemIsRefused) {
  const auto refused = [&](const auto& change, const std::string& why) {
    const bccsplat_writer_options before = options;
    change();
    EXPECT_EQ(created(), BCCSPLAT_ERROR_UNSUPPORTED);
    EXPECT_NE(std::string(bccsplat_last_error()).find(why), std::string::npos) << bccsplat_last_error();
    options = before;
  };
  const std::string whole =
      "labels come back whole from samples of lattice CC at distance 1 alone; store them so";
  refused([&] { options.lattice = BCCSPLAT_LATTICE_D4STAR; }, whole);
  refused([&] { options.scale = 1.5; }, whole);
  refused([&] { options.store = BCCSPLAT_STORE_WAVELETS, options.abs_error = 1; }, whole);
  refused([&] { options.levels = 1; },
          "labels have no means, of which coarser levels are made; store none of these");
  EXPECT_EQ(created(), BCCSPLAT_OK);
  channel.set_mask |= BCCSPLAT_CHANNEL_QUANTITIES;
  EXPECT_EQ(created(), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

// Those that nobody named may have levels, which are means of them.
TEST_F(SaidLabels, LevelsThatAreThereAreNotShown) {
  series.field = [](double x, double, double, double) { return x < 10 ? 3 : 7; };
  channel.source_type = channel.value_type = BCCSPLAT_TYPE_U8;
  channel.set_mask = 0, options.levels = 1;
  write();
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -1;
  auto o = sized<bccsplat_slice_options>();
  o.level = 1;
  bccsplat_slice* made = nullptr;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &plane, &o, &made), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("take level 0"), std::string::npos);
}

} // namespace
} // namespace host
