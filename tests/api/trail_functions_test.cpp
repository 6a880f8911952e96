// SPDX-License-Identifier: Apache-2.0
// What a trail is made of, by pictures that are known in numbers: a transfer function for each sub-interval,
// the curve of a shutter, and trails among several instances of a scene.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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

TEST_F(TrailFunctions, CountByTheCurveOfTheShutter) {
  std::array<bccsplat_transfer_function, 2> functions{function(0.05, early), function(0.02, late)};
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4, trail.intervals = 2;
  trail.transfer_functions = functions.data();
  const std::array<double, 2> weights{3, 1}; // three quarters and one
  trail.weights = weights.data();
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const double red = -std::log(1 - 0.05) * 0.75, blue = -std::log(1 - 0.02) * 0.25;
  const double alpha = 1 - std::exp(-(red + blue) * length);
  const auto own = draw();
  EXPECT_NEAR(own[0], alpha * red / (red + blue), 1e-3);
  EXPECT_NEAR(own[2], alpha * blue / (red + blue), 1e-3);
  EXPECT_NEAR(own[3], alpha, 1e-3);
  // Equal weights are none, bit for bit, whatever their unit.
  const std::array<double, 2> alike{0.5, 0.5};
  trail.weights = alike.data();
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const auto even = draw();
  trail.weights = nullptr;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  EXPECT_EQ(even, draw());
  // What has no weight is not there.
  const std::array<double, 2> only{0, 5};
  trail.weights = only.data();
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const auto last = draw();
  EXPECT_EQ(last[0], 0);
  EXPECT_NEAR(last[3], 1 - std::pow(1 - 0.02, length), 1e-3);
}

TEST_F(TrailFunctions, OfAShutterHaveTheirOwnColour) {
  const bccsplat_transfer_function one = function(0.05, early); // red
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4, trail.intervals = 2, trail.transfer_function = &one;
  const std::array<double, 2> weights{1, 2};
  trail.weights = weights.data();
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const auto own = draw();
  EXPECT_NEAR(own[0], own[3], 1e-6);
  EXPECT_EQ(own[1], 0);
  EXPECT_EQ(own[2], 0);
}

TEST_F(TrailFunctions, RefuseAShutterThatIsNeverOpen) {
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -4, trail.intervals = 2;
  std::array<double, 2> weights{0, 0};
  trail.weights = weights.data();
  EXPECT_EQ(bccsplat_renderer_set_trail(renderer.get(), &trail), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("all 0"), std::string::npos);
  weights = {1, -1};
  EXPECT_EQ(bccsplat_renderer_set_trail(renderer.get(), &trail), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

// The same field as one or two instances of a scene.
class TrailInstances : public TrailFunctions {
 protected:
  TrailInstances() {
    bccsplat_scene* s = nullptr;
    EXPECT_OK(bccsplat_scene_create(device.get(), &s));
    scene.reset(s);
    EXPECT_OK(bccsplat_scene_set_time(s, 6));
    options.shading = BCCSPLAT_SHADING_OFF, options.opacity_stop = 1;
    EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 0, 0, size, size, &camera));
    past.interval[0] = -4, past.transfer_function = &blue;
  }
  void add(const bccsplat_transfer_function& f, const bccsplat_trail* trail) {
    auto i = sized<bccsplat_instance>();
    i.transfer_function = &f, i.trail = trail;
    uint64_t id = 0;
    ASSERT_OK(bccsplat_scene_add(scene.get(), volume.get(), &i, &id));
  }
  bccsplat_status render(std::vector<float>& rgba) {
    rgba.assign(4 * size * size, 0);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), size, size, rgba.data(), 0, &f));
    const Frame frame(f);
    auto view = sized<bccsplat_view>();
    view.camera = &camera;
    return bccsplat_scene_render(scene.get(), &view, f, &options, 0, nullptr);
  }
  std::array<float, 4> middle() {
    std::vector<float> rgba;
    EXPECT_OK(render(rgba));
    std::array<float, 4> pixel{};
    std::copy_n(rgba.begin() + 4 * (size / 2 * size + size / 2), 4, pixel.begin());
    return pixel;
  }

  Handle<bccsplat_scene> scene;
  bccsplat_render_options options = sized<bccsplat_render_options>();
  bccsplat_camera camera = sized<bccsplat_camera>();
  Points of_green{{0, 0, 1, 0}, {}};
  bccsplat_transfer_function red = function(0.05, early), blue = function(0.02, late),
                             green = function(0.03, of_green);
  const double of_red = -std::log(1 - 0.05), of_blue = -std::log(1 - 0.02), of_third = -std::log(1 - 0.03);
  bccsplat_trail past = sized<bccsplat_trail>();
};

TEST_F(TrailInstances, OneIsTheRenderersPicture) {
  ASSERT_OK(bccsplat_renderer_set_transfer_function(renderer.get(), &red));
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &past));
  const auto own = draw();
  add(red, &past);
  EXPECT_EQ(middle(), own);
}

TEST_F(TrailInstances, ExtinctionsOfAllAdd) {
  add(red, &past);
  add(green, nullptr);
  const double sum = of_red + of_blue + of_third, alpha = 1 - std::exp(-sum * length);
  const auto pixel = middle();
  EXPECT_NEAR(pixel[0], alpha * of_red / sum, 1e-3);
  EXPECT_NEAR(pixel[1], alpha * of_third / sum, 1e-3);
  EXPECT_NEAR(pixel[2], alpha * of_blue / sum, 1e-3);
}

// Equation (8) joins a slice with its own trail, and depends on the step: the opacity of a sheet is the mean
// of both. The sum is done by hand, over the sheets around the middle of the box, the outermost of which are
// cut by its faces.
TEST_F(TrailInstances, EquationEightAsPrintedIsOfEachPairAlone) {
  past.combine = BCCSPLAT_TRAIL_INTERLEAVED;
  constexpr double opacity_of_blue = 0.6;
  options.sheet_step = 1;
  blue = function(opacity_of_blue, late);
  add(red, &past);
  add(green, nullptr);
  const double step = length / 13 / std::sqrt(2.0); // a T: 13 planes of each grid fit the box
  std::array<double, 4> sum{};
  for (int k = -9; k <= 9; ++k) {
    const double part = std::min((k + 0.5) * step, length / 2) - std::max((k - 0.5) * step, -length / 2);
    const double a = 1 - std::exp(-of_red * part), b = 1 - std::pow(1 - opacity_of_blue, part);
    const double pair = -std::log(1 - (a + b) / 2), third = of_third * part;
    const double alpha = (1 - sum[3]) * (1 - std::exp(-(pair + third)));
    sum[0] += alpha * pair * a / (a + b) / (pair + third);
    sum[1] += alpha * third / (pair + third);
    sum[2] += alpha * pair * b / (a + b) / (pair + third);
    sum[3] += alpha;
  }
  const auto pixel = middle();
  for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(pixel[c], sum[c], 1e-4) << c;
}

TEST_F(TrailInstances, RefuseWhatHasNoPlaceInAPicture) {
  auto i = sized<bccsplat_instance>();
  i.set_mask = BCCSPLAT_INSTANCE_SET_MASK_CHANNEL, i.trail = &past;
  uint64_t id = 0;
  EXPECT_EQ(bccsplat_scene_add(scene.get(), volume.get(), &i, &id), BCCSPLAT_ERROR_UNSUPPORTED);
}

// Blobs that move, whose slice and trail lights and surfaces change.
class TrailBlobs : public testing::Test {
 protected:
  TrailBlobs() {
    write_series(device, folder.file("b.bcc4"));
    volume = open(device, folder.file("b.bcc4"));
    past.interval[0] = -5;
  }
  // A picture of the blobs, and of the same ones beside them by so much.
  std::vector<float> draw(const bccsplat_render_options& options, const std::vector<double>& moves) {
    bccsplat_scene* s = nullptr;
    EXPECT_OK(bccsplat_scene_create(device.get(), &s));
    const Handle<bccsplat_scene> scene(s);
    EXPECT_OK(bccsplat_scene_set_time(s, 6));
    for (const double move : moves) {
      auto i = sized<bccsplat_instance>();
      for (size_t a = 0; a < 4; ++a) i.placement[5 * a] = 1;
      i.placement[3] = move, i.trail = &past;
      uint64_t id = 0;
      EXPECT_OK(bccsplat_scene_add(s, volume.get(), &i, &id));
    }
    auto camera = sized<bccsplat_camera>();
    camera.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, camera.ortho_height = 20;
    for (double* p : {camera.position, camera.target}) p[0] = p[1] = 10;
    camera.position[2] = 200, camera.up[1] = 1;
    auto view = sized<bccsplat_view>();
    view.camera = &camera;
    std::vector<float> rgba(4 * pixels * pixels);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), pixels, pixels, rgba.data(), 0, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_scene_render(s, &view, f, &options, 0, nullptr));
    return rgba;
  }
  static constexpr uint32_t pixels = 40;
  Folder folder;
  Device device = make_device();
  Volume volume;
  bccsplat_trail past = sized<bccsplat_trail>();
};

TEST_F(TrailBlobs, UnlitTrailsOfUnlitPicturesAreTrails) {
  auto options = sized<bccsplat_render_options>();
  const auto lit = draw(options, {0});
  past.unlit = 1;
  const auto unlit = draw(options, {0});
  EXPECT_GT(largest_difference(lit, unlit), 0.02);
  options.shading = BCCSPLAT_SHADING_OFF;
  const auto off = draw(options, {0});
  EXPECT_GT(largest_difference(off, unlit), 0.02); // whose slice is lit
  past.unlit = 0;
  EXPECT_EQ(off, draw(options, {0}));
}

// The surface of one stays as it is beside another, whose picture is elsewhere.
TEST_F(TrailBlobs, SurfacesOfInstancesHaveTheirTrails) {
  auto options = sized<bccsplat_render_options>();
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.set_mask = BCCSPLAT_RENDER_SET_ISO;
  options.iso_value = 50, options.smooth_edges = BCCSPLAT_SMOOTH_EDGES_OFF;
  const auto alone = draw(options, {0}), both = draw(options, {0, 12});
  double most = 0, other = 0;
  for (size_t p = 0; p < alone.size(); p += 4) // columns before the other one's domain
    if ((p / 4) % pixels < 22)
      for (size_t c = 0; c < 4; ++c) most = std::max(most, std::fabs(double{alone[p + c]} - both[p + c]));
    else
      other = std::max(other, double{both[p + 3]} - alone[p + 3]);
  EXPECT_LT(most, 5e-3);
  EXPECT_GT(other, 0.5); // it is there
}

} // namespace
} // namespace host
