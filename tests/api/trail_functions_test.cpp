// SPDX-License-Identifier: Apache-2.0
// A transfer function for each sub-interval of a trail, by pictures that are known in numbers.
#include <array>
#include <cmath>

#include "support.h"

namespace host {
namespace {

// A field that is 1 everywhere, which a camera along z looks through for 17 units. The slice is transparent.
class TrailFunctions : public testing::Test {
 protected:
  static constexpr uint32_t size = 8;
  static constexpr double length = 17;

  TrailFunctions() {
    Series s;
    s.field = [](double, double, double, double) { return 1.0; };
    write_series(device, folder.file("v.bcc4"), s);
    volume = open(device, folder.file("v.bcc4"));
    slice = cut(volume, 0, 0, 0, 1, -6);
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    renderer.reset(r);
    auto options = sized<bccsplat_render_options>();
    options.shading = BCCSPLAT_SHADING_OFF, options.opacity_stop = 1;
    EXPECT_OK(bccsplat_renderer_set_options(r, &options));
    auto camera = sized<bccsplat_camera>();
    EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 0, 0, size, size, &camera));
    EXPECT_OK(bccsplat_renderer_set_camera(r, &camera));
    EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    const bccsplat_transfer_function nothing = function(0, clear);
    EXPECT_OK(bccsplat_renderer_set_transfer_function(r, &nothing));
  }

  // Opacity per unit at every value, of one colour.
  struct Points {
    std::array<double, 4> color{0, 0, 0, 0};
    std::array<double, 2> opacity{0, 0};
  };
  static bccsplat_transfer_function function(double opacity, Points& p) {
    p.opacity = {0, opacity};
    auto f = sized<bccsplat_transfer_function>();
    f.colors = p.color.data(), f.color_count = 1;
    f.opacities = p.opacity.data(), f.opacity_count = 1;
    f.unit_distance = 1;
    return f;
  }
  // The pixel in the middle.
  std::array<float, 4> draw() {
    std::vector<float> rgba(4 * size * size);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), size, size, rgba.data(), 0, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_renderer_render(renderer.get(), f));
    std::array<float, 4> pixel{};
    std::copy_n(rgba.begin() + 4 * (size / 2 * size + size / 2), 4, pixel.begin());
    return pixel;
  }

  Folder folder;
  Device device = make_device();
  Volume volume;
  Slice slice;
  Renderer renderer;
  Points clear, early{{0, 1, 0, 0}, {}}, late{{0, 0, 0, 1}, {}};
};

TEST_F(TrailFunctions, AreThoseOfTheirSubIntervals) {
  // Red of opacity 0.05 per unit in the first half, blue of 0.02 in the second: extinctions average.
  std::array<bccsplat_transfer_function, 2> functions{function(0.05, early), function(0.02, late)};
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4, trail.intervals = 2;
  trail.transfer_functions = functions.data();
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const double red = -std::log(1 - 0.05) / 2, blue = -std::log(1 - 0.02) / 2;
  const double alpha = 1 - std::exp(-(red + blue) * length);
  const auto own = draw();
  EXPECT_NEAR(own[0], alpha * red / (red + blue), 1e-3);
  EXPECT_NEAR(own[1], 0, 1e-6);
  EXPECT_NEAR(own[2], alpha * blue / (red + blue), 1e-3);
  EXPECT_NEAR(own[3], alpha, 1e-3);
  // Colours that are given take their places.
  const double green[6] = {0, 1, 0, 0, 1, 0};
  trail.colors = green;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const auto tinted = draw();
  EXPECT_NEAR(tinted[1], alpha, 1e-3);
  EXPECT_NEAR(tinted[0] + tinted[2], 0, 1e-6);
}

TEST_F(TrailFunctions, OneForAllIsAsBefore) {
  const bccsplat_transfer_function one = function(0.05, early);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4, trail.intervals = 1, trail.transfer_functions = &one;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const auto listed = draw();
  trail.transfer_functions = nullptr, trail.transfer_function = &one;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  EXPECT_EQ(listed, draw());
  // A host of an earlier header has no list.
  trail.struct_size = offsetof(bccsplat_trail, transfer_functions);
  trail.transfer_functions = &one; // which is not read
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  EXPECT_EQ(listed, draw());
}

TEST_F(TrailFunctions, Refused) {
  std::array<bccsplat_transfer_function, 2> functions{function(0.05, early), function(0.02, late)};
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4, trail.intervals = 2;
  trail.transfer_functions = functions.data(), trail.transfer_function = functions.data();
  EXPECT_EQ(bccsplat_renderer_set_trail(renderer.get(), &trail), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("one of the two"), std::string::npos);
  trail.transfer_function = nullptr;
  functions[1].struct_size = 8;
  EXPECT_EQ(bccsplat_renderer_set_trail(renderer.get(), &trail), BCCSPLAT_ERROR_INVALID_STRUCT_SIZE);
}

} // namespace
} // namespace host
