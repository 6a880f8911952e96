// SPDX-License-Identifier: Apache-2.0
// What rays meet, against a ball and a ramp that are known.
#include <array>
#include <cmath>

#include "support.h"

namespace host {
namespace {

using Position = std::array<double, 3>;

constexpr double ball_at = 16, ball_width = 50; // of the ball
double soft_ball(double x, double y, double z, double) {
  const double r =
      (x - ball_at) * (x - ball_at) + (y - ball_at) * (y - ball_at) + (z - ball_at) * (z - ball_at);
  return 100 * std::exp(-r / ball_width);
}
double along_x(double x, double, double, double) { return x; }

class Pick : public testing::Test {
 protected:
  void write(const decltype(Series::field)& field, double distance = 1, uint32_t levels = 0) {
    Series s;
    s.nx = s.ny = s.nz = 33, s.nt = 2, s.field = field;
    auto o = options_of(s);
    // The world is twice as large, and moved.
    for (size_t a = 0; a < 3; ++a) o.affine[5 * a] = scale, o.affine[4 * a + 3] = shift[a];
    o.affine[15] = 1;
    o.scale = distance, o.levels = levels, o.overwrite = 1;
    const std::string path = folder.free_file("v.bcc4");
    const Writer w = make_writer(device, path, o);
    EXPECT_OK(add_frames(w.get(), s));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    volume = open(device, path);
    slice = cut_time(volume, 0);
  }
  static Position world(const Position& index) {
    return {scale * index[0] + shift[0], scale * index[1] + shift[1], scale * index[2] + shift[2]};
  }
  static bccsplat_ray towards(bccsplat_pick what, const Position& from, const Position& to,
                              double threshold) {
    auto ray = sized<bccsplat_ray>();
    ray.pick = what, ray.threshold = threshold;
    for (size_t a = 0; a < 3; ++a) ray.origin[a] = world(from)[a], ray.direction[a] = to[a] - from[a];
    return ray;
  }
  bccsplat_hit pick(const bccsplat_ray& ray) const {
    auto hit = sized<bccsplat_hit>();
    EXPECT_OK(bccsplat_slice_pick(slice.get(), &ray, &hit));
    return hit;
  }

  static constexpr double scale = 2;
  static constexpr Position shift{100, -50, 7};
  Folder folder;
  Device device = make_device();
  Volume volume;
  Slice slice;
};

TEST_F(Pick, FindsTheSurfaceOfABall) {
  write(soft_ball);
  // Obliquely through the centre: the surface at 50 is sqrt(ball_width ln 2) around it.
  const Position from{-20, -4, 10}, along{36, 20, 6};
  const double far = std::sqrt(36 * 36 + 20 * 20 + 6 * 6), radius = std::sqrt(ball_width * std::log(2));
  const bccsplat_ray ray = towards(BCCSPLAT_PICK_VALUE, from, {16, 16, 16}, 50);
  const bccsplat_hit hit = pick(ray);
  ASSERT_EQ(hit.found, 1);
  EXPECT_NEAR(hit.distance, scale * (far - radius), 0.02);
  EXPECT_NEAR(hit.value, 50, 0.05);
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(hit.uvw[a], ball_at - radius * along[a] / far, 0.01);
    EXPECT_NEAR(hit.world[a], scale * hit.uvw[a] + shift[a], 1e-9);
    // It rises towards the centre, by 2 r / ball_width of the value and unit, of which the kernel's ripple
    // changes some hundredths.
    EXPECT_NEAR(hit.gradient[a], 50 * 2 * radius / ball_width * along[a] / far / scale, 0.25);
  }
  // The value and the gradient are those of the slice there.
  float value = 0;
  std::array<float, 3> slope{};
  ASSERT_OK(bccsplat_slice_evaluate(slice.get(), 1, hit.uvw, &value, slope.data()));
  EXPECT_EQ(hit.value, value);
  for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(hit.gradient[a], slope[a] / scale, 1e-5);
  // Beyond the first surface it is the second, and beyond that none.
  bccsplat_ray rest = ray;
  rest.begin = hit.distance + 1, rest.end = 1e3;
  EXPECT_NEAR(pick(rest).distance, scale * (far + radius), 0.02);
  rest.begin = scale * (far + radius) + 1;
  EXPECT_EQ(pick(rest).found, 0);
  rest.begin = 0, rest.end = hit.distance - 0.1;
  EXPECT_EQ(pick(rest).found, 0);
}

TEST_F(Pick, IsTheSameInSlicesOfOtherDistancesAndDirections) {
  const Position from{-20, -4, 10}, to{16, 16, 16};
  const double far = std::sqrt(36 * 36 + 20 * 20 + 6 * 6), radius = std::sqrt(ball_width * std::log(2));
  const auto expect_ball = [&](const char* what) {
    const bccsplat_ray ray = towards(BCCSPLAT_PICK_VALUE, from, to, 50);
    const bccsplat_hit hit = pick(ray);
    ASSERT_EQ(hit.found, 1) << what;
    EXPECT_NEAR(hit.distance, scale * (far - radius), 0.3) << what;
    bccsplat_ray rest = ray;
    rest.begin = hit.distance + 1, rest.end = 1e3;
    EXPECT_NEAR(pick(rest).distance, scale * (far + radius), 0.3) << what;
  };
  write(soft_ball, 1.3);
  expect_ball("a lattice of other distances");
  write(soft_ball, 1, 1);
  auto h = sized<bccsplat_hyperplane>();
  h.d = 1;
  auto o = sized<bccsplat_slice_options>();
  o.level = 1;
  bccsplat_slice* s = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &h, &o, &s));
  slice = Slice(s);
  expect_ball("a coarser level");
  o.level = 0, o.spacing = 0.75;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &h, &o, &s));
  slice = Slice(s);
  expect_ball("a finer slice");
  // Turned by an eighth about z; the field is the same at all times.
  const std::array<double, 4> point{16, 16, 16, 0.5};
  const double half = std::sqrt(0.5);
  const std::array<double, 12> basis{half, half, 0, 0, -half, half, 0, 0, 0, 0, 1, 0};
  o.spacing = 0, o.point = point.data(), o.basis = basis.data();
  ASSERT_OK(bccsplat_slice_create(volume.get(), nullptr, &o, &s));
  slice = Slice(s);
  expect_ball("a slice along other axes");
}

TEST_F(Pick, OfUnevenAxes) {
  // Samples along z stand at the squares of their numbers: the field is a slope along the world's z.
  Series s;
  s.nx = s.ny = s.nz = 12, s.nt = 1;
  s.field = [](double, double, double z, double) { return z * z; };
  std::array<double, 12> coordinates{};
  for (size_t n = 0; n < coordinates.size(); ++n) coordinates[n] = static_cast<double>(n * n);
  auto axes = std::array{sized<bccsplat_axis>(), sized<bccsplat_axis>(), sized<bccsplat_axis>()};
  axes[2].count = coordinates.size(), axes[2].coordinates = coordinates.data();
  auto o = options_of(s);
  o.affine[0] = o.affine[5] = o.affine[15] = 1, o.affine[10] = 11; // of even positions, as far in all
  o.axes = axes.data();
  const Writer w = make_writer(device, folder.file("v.bcc4"), o);
  ASSERT_OK(add_frames(w.get(), s));
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  volume = open(device, folder.file("v.bcc4"));
  auto h = sized<bccsplat_hyperplane>();
  h.d = 1;
  auto even = sized<bccsplat_slice_options>();
  even.space = BCCSPLAT_SPACE_EVEN;
  bccsplat_slice* cut = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &h, &even, &cut));
  slice = Slice(cut);
  for (const double height : {7.0, 30.0, 65.0}) {
    auto ray = sized<bccsplat_ray>();
    ray.pick = BCCSPLAT_PICK_VALUE, ray.threshold = height;
    ray.origin[0] = 5, ray.origin[1] = 6, ray.origin[2] = -10, ray.direction[2] = 1;
    const bccsplat_hit hit = pick(ray);
    ASSERT_EQ(hit.found, 1) << height;
    EXPECT_NEAR(hit.world[2], height, 1) << height;
  }
}

TEST_F(Pick, FindsTheLargestValue) {
  write(soft_ball);
  // Past the centre by 3: the largest is nearest to it.
  const bccsplat_hit hit = pick(towards(BCCSPLAT_PICK_MAXIMUM, {-10, 19, 16}, {40, 19, 16}, 0));
  ASSERT_EQ(hit.found, 1);
  EXPECT_NEAR(hit.uvw[0], ball_at, 0.02);
  EXPECT_NEAR(hit.value, 100 * std::exp(-9 / ball_width), 0.3); // which the field itself is off by
  EXPECT_NEAR(hit.distance, scale * 26, 0.04);
}

TEST_F(Pick, FindsWhereTheOpacityIsReached) {
  write(along_x);
  // The extinction of a value is value / 1000 per world unit: along x it is that of the ramp's integral.
  constexpr uint32_t points = 65;
  std::array<double, 2 * points> opacities{};
  for (uint32_t n = 0; n < points; ++n)
    opacities[2 * n] = 0.5 * n, opacities[2 * n + 1] = -std::expm1(-0.5 * n / 1000);
  const std::array<double, 4> white{0, 1, 1, 1};
  auto f = sized<bccsplat_transfer_function>();
  f.colors = white.data(), f.color_count = 1, f.unit_distance = 1;
  f.opacities = opacities.data(), f.opacity_count = points;
  bccsplat_ray ray = towards(BCCSPLAT_PICK_OPACITY, {-5, 16, 16}, {32, 16, 16}, 0.25);
  ray.transfer_function = &f;
  const bccsplat_hit hit = pick(ray);
  ASSERT_EQ(hit.found, 1);
  // scale x^2 / 2 / 1000 = -log(1 - 0.25)
  const double x = std::sqrt(-std::log(0.75) * 2000 / scale);
  EXPECT_NEAR(hit.uvw[0], x, 0.05);
  EXPECT_NEAR(hit.value, x, 0.05);
  ray.threshold = 0.9; // more than all of it: 1 - exp(-2 * 512 / 1000) = 0.64
  EXPECT_EQ(pick(ray).found, 0);
  ray.threshold = 1.5;
  auto refused = sized<bccsplat_hit>();
  EXPECT_EQ(bccsplat_slice_pick(slice.get(), &ray, &refused), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

TEST_F(Pick, OfAPixelIsTheDepthOfThePicture) {
  write(soft_ball);
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, 40, 30, &camera));
  auto view = sized<bccsplat_view>();
  view.camera = &camera;
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  auto options = sized<bccsplat_render_options>();
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 50;
  ASSERT_OK(bccsplat_renderer_set_options(r, &options));
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  ASSERT_OK(bccsplat_renderer_set_view(r, &view));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 40, 30, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEPTH, &f));
  const Frame frame(f);
  ASSERT_OK(bccsplat_renderer_render(r, f));
  auto plane = sized<bccsplat_plane>();
  ASSERT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_DEPTH, &plane));
  int met = 0;
  for (uint32_t j = 0; j < 30; j += 2)
    for (uint32_t i = 0; i < 40; i += 2) {
      const std::array<double, 6> pixels{i + 0.5, j + 0.5, 0, i + 0.5, j + 0.5, 1};
      std::array<double, 6> xyz{};
      ASSERT_OK(bccsplat_view_unproject(&view, 40, 30, 2, pixels.data(), xyz.data()));
      auto ray = sized<bccsplat_ray>();
      ray.pick = BCCSPLAT_PICK_VALUE, ray.threshold = 50;
      for (size_t a = 0; a < 3; ++a) ray.origin[a] = xyz[a], ray.direction[a] = xyz[3 + a] - xyz[a];
      const bccsplat_hit hit = pick(ray);
      const float depth = static_cast<const float*>(plane.pixels)[j * plane.row_bytes / sizeof(float) + i];
      ASSERT_EQ(hit.found == 1, std::isfinite(depth)) << i << ' ' << j;
      if (hit.found == 0) continue;
      ++met;
      std::array<double, 3> seen{};
      ASSERT_OK(bccsplat_view_project(&view, 40, 30, 1, hit.world, seen.data()));
      EXPECT_NEAR(seen[0], i + 0.5, 1e-6);
      EXPECT_NEAR(seen[2], depth, 0.02);
    }
  EXPECT_GT(met, 5);
}

// Of one sample along z a slice is drawn half a sample's distance to either side, and picked there, too.
TEST_F(Pick, MeetsWhatIsFlat) {
  Series s;
  s.nx = s.ny = 33, s.nz = 1, s.nt = 2, s.field = [](double x, double, double, double) { return 3 * x; };
  const std::string path = folder.free_file("flat.bcc4");
  const Writer w = make_writer(device, path, options_of(s));
  ASSERT_OK(add_frames(w.get(), s));
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  volume = open(device, path), slice = cut_time(volume, 0);
  auto ray = sized<bccsplat_ray>();
  ray.pick = BCCSPLAT_PICK_MAXIMUM;
  ray.origin[0] = 16, ray.origin[1] = 12, ray.origin[2] = 7.3;
  ray.direction[0] = 0.05, ray.direction[2] = -1;
  bccsplat_hit hit = pick(ray);
  ASSERT_EQ(hit.found, 1);
  EXPECT_NEAR(hit.value, 3 * (16 + 0.05 * 7.8), 0.1) << "where the ray leaves";
  const double colors[8] = {0, 1, 1, 1, 100, 1, 1, 1}, opacities[4] = {0, 0.5, 100, 0.5};
  auto f = sized<bccsplat_transfer_function>();
  f.colors = colors, f.color_count = 2, f.opacities = opacities, f.opacity_count = 2, f.unit_distance = 1;
  // One sample's distance of half the light: 0.4 of it is there after ln 0.6 / ln 0.5 of that.
  ray.pick = BCCSPLAT_PICK_OPACITY, ray.threshold = 0.4, ray.transfer_function = &f;
  ray.direction[0] = 0;
  hit = pick(ray);
  ASSERT_EQ(hit.found, 1);
  EXPECT_NEAR(hit.distance, 7.3 - 0.5 + std::log(0.6) / std::log(0.5), 0.02);
}

} // namespace
} // namespace host
