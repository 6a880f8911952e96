// SPDX-License-Identifier: Apache-2.0
// Pictures of extracted points, splatted sheet by sheet, are compared with rays through the same field,
// summed point by point.
#include <gtest/gtest.h>

#include <memory>

#include "scene/picture.h"
#include "slice/extraction.h"
#include "slice/plane_slice.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"

namespace bccsplat {
namespace {

using test::TestContext;

class ExtractedPicture : public testing::Test {
 protected:
  static constexpr int width = 60, height = 48;

  // A ball that runs along x, of values up to 1.
  static MemorySamples series(LatticeKind kind) {
    return test::sample_field(Lattice4::fit(kind, {24, 18, 19, 14}), [](const Vec4& p) {
      const double x = p[0] - 6 - 0.8 * p[3], y = p[1] - 8.5, z = p[2] - 9;
      return std::exp(-(x * x + y * y + z * z) / 18);
    });
  }
  Slice extracted(const MemorySamples& samples, const Hyperplane& h) {
    const Coefficients coefficients(samples, 0, make_kernel("paper"), 0, test::large_cache);
    Slice slice = bare_plane(coefficients, h, {}, {});
    const auto points = std::make_shared<const Extraction>(
        samples, 0, h, PlaneAxes{slice.origin, slice.basis}, slice.lattice_to_slice, context.get());
    slice.scattered = points, slice.bounds = points->bounds();
    return slice;
  }
  std::vector<float> draw(const Slice& slice, const RenderOptions& options, bool perspective = false) {
    ImageStorage image(width, height);
    (void)render(scene_of(slice, perspective), options, context.get(), image.image);
    return image.rgba;
  }
  Scene scene_of(const Slice& slice, bool perspective) {
    Scene scene;
    scene.slice = &slice, scene.camera = fit_camera(slice, perspective, 20, 30, width, height);
    scene.function.colors = {{0, {0.2, 0.4, 0.9}}, {1, {0.9, 0.5, 0.2}}};
    scene.function.opacities = {{0.1, 0}, {1, 0.5}};
    return scene;
  }
  TestContext context;
};

TEST_F(ExtractedPicture, IsThatOfItsField) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const MemorySamples samples = series(kind);
    for (const Hyperplane& h : {Hyperplane{0, 0, 0, 1, -6.3}, Hyperplane{0.5, 0.3, 0, 0.8, -12}}) {
      const Slice slice = extracted(samples, h);
      for (const RenderMode mode :
           {RenderMode::composite, RenderMode::isosurface, RenderMode::xray, RenderMode::maximum})
        for (const bool perspective : {false, true}) {
          RenderOptions options;
          options.mode = mode, options.iso_value = 0.4, options.sheet_step = 0.25;
          options.shading = mode == RenderMode::isosurface;
          const auto drawn = draw(slice, options, perspective);
          options.reference = true;
          const auto truth = draw(slice, options, perspective);
          const float most = *std::max_element(truth.begin(), truth.end());
          EXPECT_GT(most, 0.2f);
          double square = 0;
          for (size_t i = 0; i < truth.size(); ++i) square += std::pow((drawn[i] - truth[i]) / most, 2);
          EXPECT_LT(std::sqrt(square / static_cast<double>(truth.size())), 0.01)
              << static_cast<int>(mode) << perspective;
        }
    }
  }
}

TEST_F(ExtractedPicture, IsShadedByDifferencesOfItsSheets) {
  const Slice slice = extracted(series(LatticeKind::d4star), {0, 0, 0, 1, -6.3});
  RenderOptions options;
  options.sheet_step = 0.25;
  const auto drawn = draw(slice, options);
  options.reference = true;
  const auto truth = draw(slice, options);
  double square = 0;
  for (size_t i = 0; i < truth.size(); ++i) square += std::pow(drawn[i] - truth[i], 2);
  EXPECT_LT(std::sqrt(square / static_cast<double>(truth.size())), 0.01);
}

// Nothing is left out for its size, and no tile or thread changes a bit.
TEST_F(ExtractedPicture, TilesThreadsAndSkipsDoNotChangeIt) {
  const Slice slice = extracted(series(LatticeKind::d4star), {0.5, 0.3, 0, 0.8, -12});
  RenderOptions options;
  const auto drawn = draw(slice, options);
  options.tile_size = 17;
  EXPECT_EQ(drawn, draw(slice, options));
  TestContext alone(1);
  ImageStorage image(width, height);
  (void)render(scene_of(slice, false), options, alone.get(), image.image);
  EXPECT_EQ(drawn, image.rgba);
  options.disable_skips = 127;
  EXPECT_LT(largest_difference(drawn, draw(slice, options)), 1e-6);
}

} // namespace
} // namespace bccsplat
