// SPDX-License-Identifier: Apache-2.0
// Coarser levels of a file, as hosts see them.
#include "support.h"

namespace host {
namespace {

// A field that every level holds: waves of 30 samples and more.
double smooth(double x, double y, double z, double t) {
  return 100 + 40 * std::sin(0.21 * x + 0.1 * t) * std::cos(0.15 * y) + 20 * std::cos(0.17 * z);
}

class Levels : public testing::Test {
 protected:
  // Writes the series with coarser levels and opens what was written.
  [[nodiscard]] Volume stored(uint32_t levels, int32_t store, double abs_error = 0) const {
    auto o = options_of(series);
    o.levels = levels, o.store = store, o.overwrite = 1, o.abs_error = abs_error;
    const std::string path = folder.file("v");
    const Writer w = make_writer(device, path, o);
    EXPECT_OK(add_frames(w.get(), series));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    return open(device, path);
  }
  [[nodiscard]] static Slice cut_level(const Volume& volume, uint32_t level) {
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -2.5;
    auto options = sized<bccsplat_slice_options>();
    options.level = level;
    bccsplat_slice* slice = nullptr;
    EXPECT_OK(bccsplat_slice_create(volume.get(), &plane, &options, &slice));
    return Slice(slice);
  }
  // The largest error of a slice at points away from the faces.
  [[nodiscard]] double error(const Slice& slice) const {
    std::vector<double> uvw;
    for (double x = 8; x < 36; x += 3.3)
      for (double y = 8; y < 36; y += 4.1)
        for (double z = 8; z < 36; z += 5.7) uvw.insert(uvw.end(), {x, y, z});
    std::vector<float> values(uvw.size() / 3);
    EXPECT_OK(bccsplat_slice_evaluate(slice.get(), values.size(), uvw.data(), values.data(), nullptr));
    double largest = 0;
    for (size_t i = 0; i < values.size(); ++i)
      largest = std::max(largest, std::fabs(static_cast<double>(values[i]) -
                                            smooth(uvw[3 * i], uvw[3 * i + 1], uvw[3 * i + 2], 2.5)));
    return largest;
  }
  static bccsplat_slice_info info_of(const Slice& slice) {
    auto info = sized<bccsplat_slice_info>();
    EXPECT_OK(bccsplat_slice_get_info(slice.get(), &info));
    return info;
  }

  const Series series{44, 45, 46, 6, 0, 1, smooth};
  const Folder folder;
  const Device device = make_device();
};

TEST_F(Levels, SlicesAreOfAnEighthOfThePointsAndOfTheSameField) {
  for (const int32_t store : {BCCSPLAT_STORE_SAMPLES, BCCSPLAT_STORE_COEFFICIENTS}) {
    SCOPED_TRACE(store);
    const Volume volume = stored(2, store);
    auto info = sized<bccsplat_volume_info>();
    EXPECT_OK(bccsplat_volume_get_info(volume.get(), &info));
    ASSERT_EQ(info.level_count, 2u);
    uint64_t points = UINT64_MAX, bytes = UINT64_MAX, sites = UINT64_MAX;
    for (uint32_t l = 0; l <= 2; ++l) {
      SCOPED_TRACE(l);
      auto level = sized<bccsplat_level_info>();
      EXPECT_OK(bccsplat_volume_get_level_info(volume.get(), l, &level));
      EXPECT_EQ(level.layer_count, info.layer_count);
      EXPECT_NEAR(level.scales[0], 1u << l, 0.2 * (1u << l));
      EXPECT_LT(4 * level.sites_total, sites);
      EXPECT_LT(2 * level.bytes, bytes);
      sites = level.sites_total, bytes = level.bytes;
      const Slice slice = cut_level(volume, l);
      const auto cut = info_of(slice);
      EXPECT_EQ(cut.level, l);
      EXPECT_EQ(cut.dims[0], 44u);
      EXPECT_LT(4 * cut.points, points);
      points = cut.points;
      EXPECT_LT(error(slice), l == 2 ? 6 : 1);
      EXPECT_NEAR(cut.extent[2][1], 45, 1e-9);
    }
  }
}

TEST_F(Levels, ThePictureIsNearThatOfTheWholeField) {
  const Volume volume = stored(1, BCCSPLAT_STORE_SAMPLES);
  std::vector<std::vector<float>> pictures;
  for (const uint32_t level : {0u, 1u}) {
    const Slice slice = cut_level(volume, level);
    bccsplat_renderer* made = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device.get(), &made));
    const Renderer renderer(made);
    ASSERT_OK(bccsplat_renderer_set_slice(renderer.get(), slice.get()));
    std::vector<float>& picture = pictures.emplace_back(4 * 32 * 32);
    bccsplat_frame* wrapped = nullptr;
    ASSERT_OK(bccsplat_frame_wrap(device.get(), 32, 32, picture.data(), 0, &wrapped));
    const Frame frame(wrapped);
    ASSERT_OK(bccsplat_renderer_render(renderer.get(), frame.get()));
  }
  double squares = 0, brightest = 0;
  for (size_t i = 0; i < pictures[0].size(); ++i) {
    squares += std::pow(static_cast<double>(pictures[0][i] - pictures[1][i]), 2);
    brightest = std::max(brightest, static_cast<double>(pictures[0][i]));
  }
  EXPECT_GT(brightest, 0.3);
  EXPECT_GT(squares, 0) << "the same points";
  EXPECT_LT(std::sqrt(squares / static_cast<double>(pictures[0].size())), 0.02);
}

TEST_F(Levels, BoundsAndCorrectionsAreThoseOfLevelZero) {
  const Volume volume = stored(1, BCCSPLAT_STORE_SAMPLES, 0.001);
  auto channel = sized<bccsplat_channel_info>();
  EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &channel));
  ASSERT_GT(channel.corrections, 0u);
  EXPECT_LT(error(cut_level(volume, 1)), 1);
}

TEST_F(Levels, LayersAndFieldsHaveNone) {
  auto o = options_of(series);
  o.levels = 1;
  const Writer w = make_writer(device, folder.file("layers"), o);
  const std::vector<float> layer(100);
  EXPECT_EQ(bccsplat_writer_add_layer(w.get(), 0, 0, layer.data(), layer.size()), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("levels"), std::string::npos) << bccsplat_last_error();
}

} // namespace
} // namespace host
