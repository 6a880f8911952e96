// SPDX-License-Identifier: Apache-2.0
// Coarser levels of a file, as hosts see them.
#include "support.h"

#include <algorithm>
#include <numbers>

namespace host {
namespace {

// A field that every level holds: waves of 30 samples and more.
double smooth(double x, double y, double z, double t) {
  return 100 + 40 * std::sin(0.21 * x + 0.1 * t) * std::cos(0.15 * y) + 20 * std::cos(0.17 * z);
}

class Levels : public testing::Test {
 protected:
  // Writes the series with coarser levels and opens what was written.
  [[nodiscard]] Volume stored(uint32_t levels, double abs_error = 0) const {
    return stored(series, levels, abs_error);
  }
  [[nodiscard]] Volume stored(const Series& s, uint32_t levels, double abs_error = 0) const {
    auto o = options_of(s);
    o.levels = levels, o.overwrite = 1, o.abs_error = abs_error;
    o.measure = BCCSPLAT_MEASURE_SOME;
    const std::string path = folder.file("v");
    const Writer w = make_writer(device, path, o);
    EXPECT_OK(add_frames(w.get(), s));
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
      largest =
          std::max(largest, std::fabs(values[i] - smooth(uvw[3 * i], uvw[3 * i + 1], uvw[3 * i + 2], 2.5)));
    return largest;
  }
  [[nodiscard]] std::vector<float> draw(const Slice& slice, const bccsplat_render_options& options) const {
    bccsplat_renderer* made = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &made));
    const Renderer renderer(made);
    EXPECT_OK(bccsplat_renderer_set_slice(renderer.get(), slice.get()));
    EXPECT_OK(bccsplat_renderer_set_options(renderer.get(), &options));
    std::vector<float> picture(4 * 32 * 32);
    bccsplat_frame* wrapped = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), 32, 32, picture.data(), 0, &wrapped));
    const Frame frame(wrapped);
    EXPECT_OK(bccsplat_renderer_render(renderer.get(), frame.get()));
    return picture;
  }
  static double rms_difference(const std::vector<float>& a, const std::vector<float>& b) {
    double squares = 0;
    for (size_t i = 0; i < a.size(); ++i) squares += std::pow(static_cast<double>(a[i] - b[i]), 2);
    return std::sqrt(squares / static_cast<double>(a.size()));
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
  const Volume volume = stored(2);
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

TEST_F(Levels, ThePictureIsNearThatOfTheWholeField) {
  const Volume volume = stored(1);
  const auto defaults = sized<bccsplat_render_options>();
  const std::vector<float> whole = draw(cut_level(volume, 0), defaults);
  const double difference = rms_difference(whole, draw(cut_level(volume, 1), defaults));
  EXPECT_GT(*std::max_element(whole.begin(), whole.end()), 0.3f);
  EXPECT_GT(difference, 0) << "the same points";
  EXPECT_LT(difference, 0.02);
}

TEST_F(Levels, BoundsAndCorrectionsAreThoseOfLevelZero) {
  const Volume volume = stored(1, 0.001);
  auto channel = sized<bccsplat_channel_info>();
  EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &channel));
  ASSERT_GT(channel.corrections, 0u);
  EXPECT_LT(error(cut_level(volume, 1)), 1);
  // What the channel says is of level 0, and the level says the same.
  auto level = sized<bccsplat_level_info>();
  EXPECT_OK(bccsplat_volume_get_level_info(volume.get(), 0, &level));
  EXPECT_NEAR(channel.lattice_rmse / (channel.range[1] - channel.range[0]), level.relative_rmse, 1e-9);
  EXPECT_LE(channel.max_abs, 0.001);
}

TEST_F(Levels, PicturesNeedWhatTheirPixelsShow) {
  // One wave along each axis, which its mirror images go on with: the first level has it nearly whole.
  const auto waves = [](double x, double y, double z, double) {
    const auto wave = [](double at, double last) { return std::cos(2 * std::numbers::pi * at / last); };
    return 100 + 40 * wave(x, 43) * wave(y, 44) + 20 * wave(z, 45);
  };
  const Volume volume = stored({44, 45, 46, 6, 0, 1, waves}, 2);
  const Slice coarse = cut_level(volume, 2);
  auto camera = sized<bccsplat_camera>();
  const auto needs_of = [&](uint32_t size, int32_t quality, double height) {
    auto options = sized<bccsplat_render_options>();
    options.quality = quality;
    EXPECT_OK(bccsplat_slice_fit_camera(coarse.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 20, 30, size, size,
                                        &camera));
    if (height > 0) camera.ortho_height = height;
    auto needs = sized<bccsplat_picture_needs>();
    EXPECT_OK(bccsplat_slice_get_picture_needs(coarse.get(), &camera, size, size, &options, &needs));
    EXPECT_EQ(needs.seen, 1);
    return needs;
  };
  // The picture spans the diagonal of the box: 78 samples of 2 and 4 distances.
  EXPECT_EQ(needs_of(512, BCCSPLAT_QUALITY_NORMAL, 0).level, 0u);
  EXPECT_EQ(needs_of(34, BCCSPLAT_QUALITY_NORMAL, 0).level, 2u) << "levels that err by little";
  EXPECT_EQ(needs_of(16, BCCSPLAT_QUALITY_NORMAL, 0).level, 2u);
  EXPECT_EQ(needs_of(34, BCCSPLAT_QUALITY_FINE, 0).level, 0u);
  EXPECT_EQ(needs_of(60, BCCSPLAT_QUALITY_NORMAL, 0).level, 1u);
  EXPECT_EQ(needs_of(60, BCCSPLAT_QUALITY_DRAFT, 0).level, 2u);
  EXPECT_EQ(needs_of(130, BCCSPLAT_QUALITY_NORMAL, 0).level, 0u);
  EXPECT_EQ(needs_of(200, BCCSPLAT_QUALITY_DRAFT, 0).level, 0u);
  auto level = sized<bccsplat_level_info>();
  EXPECT_OK(bccsplat_volume_get_level_info(volume.get(), 1, &level));
  EXPECT_GT(level.relative_rmse, 1e-5);
  EXPECT_LT(level.relative_rmse, 0.002);
  EXPECT_OK(bccsplat_volume_get_level_info(volume.get(), 0, &level));
  EXPECT_GT(level.relative_rmse, 0);
  EXPECT_LT(level.relative_rmse, 0.001);

  // A picture of a part is drawn of that part.
  const auto part = needs_of(200, BCCSPLAT_QUALITY_NORMAL, 8);
  EXPECT_GT(part.box[1], 3);
  EXPECT_LT(part.box[4], 42);
  const Slice whole = cut_level(volume, 0);
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -2.5;
  auto options = sized<bccsplat_slice_options>();
  options.box = part.box;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, &options, &made));
  const Slice boxed(made);
  EXPECT_LT(info_of(boxed).extent[1][1] - info_of(boxed).extent[1][0], 41);
  std::vector<std::vector<float>> pictures;
  for (const bccsplat_slice* slice : {whole.get(), boxed.get()}) {
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    ASSERT_OK(bccsplat_renderer_set_slice(renderer.get(), slice));
    ASSERT_OK(bccsplat_renderer_set_camera(renderer.get(), &camera));
    std::vector<float>& picture = pictures.emplace_back(4 * 200 * 200);
    bccsplat_frame* wrapped = nullptr;
    ASSERT_OK(bccsplat_frame_wrap(device.get(), 200, 200, picture.data(), 0, &wrapped));
    const Frame frame(wrapped);
    ASSERT_OK(bccsplat_renderer_render(renderer.get(), frame.get()));
  }
  double largest = 0, brightest = 0;
  for (size_t i = 0; i < pictures[0].size(); ++i) {
    largest = larger(largest, std::fabs(static_cast<double>(pictures[0][i] - pictures[1][i])));
    brightest = std::max(brightest, static_cast<double>(pictures[0][i]));
  }
  EXPECT_GT(brightest, 0.3);
  EXPECT_LT(largest, 0.02) << "sheets lie elsewhere, the field is the same";
}

TEST_F(Levels, OtherSlicesThanThoseInTimeAreNotAsked) {
  const Volume volume = stored(1);
  auto plane = sized<bccsplat_hyperplane>();
  plane.a = 1, plane.e = -20;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, nullptr, &made));
  const Slice slice(made);
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 0, 0, 32, 32, &camera));
  auto needs = sized<bccsplat_picture_needs>();
  EXPECT_EQ(bccsplat_slice_get_picture_needs(slice.get(), &camera, 32, 32, nullptr, &needs),
            BCCSPLAT_ERROR_UNSUPPORTED);
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
