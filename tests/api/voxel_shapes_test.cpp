// SPDX-License-Identifier: Apache-2.0
// One moving field over one cube, sampled on voxels that are no cubes and of numbers that are no powers of
// two: pictures, slices and trails of it are those of cubes.
#include <algorithm>
#include <array>
#include <iostream>

#include "support.h"

namespace host {
namespace {

constexpr double edge = 40; // of the cube, in world units
constexpr uint32_t pixels = 96;

// A soft ball with stripes that moves, in cube edges and frames.
double field_at(double x, double y, double z, double t) {
  const double dx = x - 0.42 - 0.02 * t, dy = y - 0.5, dz = z - 0.55 + 0.015 * t;
  const double stripes = 0.75 + 0.25 * std::cos(14 * x + 6 * y - 9 * z);
  return 100 * stripes * std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * 0.15 * 0.15));
}

using Grid = std::array<uint32_t, 3>;

Volume stored(const Device& device, const Folder& folder, const Grid& n) {
  Series s{n[0], n[1], n[2], 8};
  s.field = [n](double x, double y, double z, double t) {
    return field_at(x / (n[0] - 1), y / (n[1] - 1), z / (n[2] - 1), t);
  };
  auto o = options_of(s);
  for (size_t a = 0; a < 3; ++a) o.affine[5 * a] = edge / (n[a] - 1);
  o.affine[15] = 1, o.overwrite = 1;
  const std::string path = folder.free_file("s.bcc4");
  const Writer w = make_writer(device, path, o);
  EXPECT_OK(add_frames(w.get(), s));
  EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
  return open(device, path);
}

struct View {
  const char* name;
  bccsplat_mode mode;
  bccsplat_projection projection;
  double x, y;  // turned by, degrees
  double frame; // the moment
  double trail; // frames that it goes back
  double least; // dB
};

std::vector<float> picture(const Device& device, const Volume& volume, const View& view) {
  const Slice slice = cut_time(volume, view.frame);
  bccsplat_renderer* r = nullptr;
  EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  auto options = sized<bccsplat_render_options>();
  options.mode = view.mode, options.quality = BCCSPLAT_QUALITY_NORMAL;
  options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 45;
  EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  EXPECT_OK(bccsplat_renderer_set_options(r, &options));
  const double colors[] = {0, 0.1, 0.2, 1, 50, 0.2, 1, 0.3, 100, 1, 0.6, 0.1}, opacities[] = {5, 0, 100, 0.3};
  auto function = sized<bccsplat_transfer_function>();
  function.color_count = 3, function.opacity_count = 2;
  function.colors = colors, function.opacities = opacities;
  function.unit_distance = 1;
  EXPECT_OK(bccsplat_renderer_set_transfer_function(r, &function));
  auto camera = sized<bccsplat_camera>();
  EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), view.projection, view.y, view.x, pixels, pixels, &camera));
  EXPECT_OK(bccsplat_renderer_set_camera(r, &camera));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -view.trail, trail.samples = 12;
  EXPECT_OK(bccsplat_renderer_set_trail(r, view.trail > 0 ? &trail : nullptr));
  std::vector<float> rgba(size_t{pixels} * pixels * 4);
  bccsplat_frame* f = nullptr;
  EXPECT_OK(bccsplat_frame_wrap(device.get(), pixels, pixels, rgba.data(), 0, &f));
  const Frame frame(f);
  EXPECT_OK(bccsplat_renderer_render(r, f));
  return rgba;
}

// Of the largest value.
double decibels(const std::vector<float>& a, const std::vector<float>& b) {
  double squares = 0, largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    squares += std::pow(static_cast<double>(a[i]) - b[i], 2);
    largest = larger(largest, std::fabs(static_cast<double>(a[i])));
  }
  EXPECT_GT(largest, 0);
  return 10 * std::log10(largest * largest * static_cast<double>(a.size()) / std::max(squares, 1e-20));
}

class VoxelShapes : public testing::Test {
 protected:
  const Folder folder;
  const Device device = make_device();
  const Grid cubes{40, 40, 40};
  const std::array<Grid, 3> others{{{40, 40, 23}, {23, 40, 40}, {40, 57, 47}}};
};

TEST_F(VoxelShapes, PicturesAreThoseOfCubes) {
  constexpr auto ortho = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, fan = BCCSPLAT_PROJECTION_PERSPECTIVE;
  const View views[] = {{"composite", BCCSPLAT_MODE_COMPOSITE, ortho, 20, 35, 3, 0, 65},
                        {"composite, half a frame on", BCCSPLAT_MODE_COMPOSITE, fan, -70, 100, 3.5, 0, 65},
                        {"X-ray", BCCSPLAT_MODE_XRAY, ortho, 20, 80, 3, 0, 75},
                        {"X-ray from near", BCCSPLAT_MODE_XRAY, fan, 45, 10, 4, 0, 75},
                        {"maximum", BCCSPLAT_MODE_MAXIMUM, ortho, 20, 35, 3, 0, 65},
                        {"maximum from near", BCCSPLAT_MODE_MAXIMUM, fan, 80, 35, 3, 0, 65},
                        {"isosurface", BCCSPLAT_MODE_ISOSURFACE, ortho, 20, 35, 3, 0, 48},
                        {"isosurface from near", BCCSPLAT_MODE_ISOSURFACE, fan, 60, 150, 2.5, 0, 48},
                        {"trail", BCCSPLAT_MODE_COMPOSITE, ortho, 20, 35, 6, 5, 65},
                        {"trail from near", BCCSPLAT_MODE_COMPOSITE, fan, -30, 80, 6, 5, 65}};
  const Volume reference = stored(device, folder, cubes);
  std::vector<std::vector<float>> expected;
  for (const View& view : views) expected.push_back(picture(device, reference, view));
  for (const Grid& n : others) {
    const Volume volume = stored(device, folder, n);
    for (size_t v = 0; v < std::size(views); ++v) {
      const double db = decibels(expected[v], picture(device, volume, views[v]));
      std::cout << n[0] << " x " << n[1] << " x " << n[2] << ", " << views[v].name << ": " << db << " dB\n";
      EXPECT_GT(db, views[v].least);
    }
  }
}

// Slices across every axis, at the same places of the cube.
TEST_F(VoxelShapes, SlicesAreThoseOfTheField) {
  std::vector<Grid> all(others.begin(), others.end());
  all.push_back(cubes);
  for (const Grid& n : all) {
    const Volume volume = stored(device, folder, n);
    for (size_t axis = 0; axis < 4; ++axis) {
      const std::array<double, 4> scale{n[0] - 1.0, n[1] - 1.0, n[2] - 1.0,
                                        1}; // index units of the cube's edges
      const double place = axis == 3 ? 3.3 : 0.53;
      std::array<double, 4> normal{};
      normal[axis] = 1;
      const Slice slice = cut(volume, normal[0], normal[1], normal[2], normal[3], -place * scale[axis]);
      std::vector<double> uvw, truth;
      for (int i = 0; i < 500; ++i) {
        std::array<double, 4> p;
        for (size_t a = 0; a < 3; ++a) p[a] = 0.15 + 0.7 * std::fmod(0.1 + i * (0.618 + 0.13 * double(a)), 1);
        p[3] = 1 + 5 * std::fmod(0.3 + i * 0.414, 1);
        p[axis] = place;
        for (size_t a = 0; a < 4; ++a)
          if (a != axis) uvw.push_back(p[a] * scale[a]);
        truth.push_back(field_at(p[0], p[1], p[2], p[3]));
      }
      std::vector<float> values(truth.size());
      ASSERT_OK(bccsplat_slice_evaluate(slice.get(), values.size(), uvw.data(), values.data(), nullptr));
      double squares = 0, worst = 0;
      for (size_t i = 0; i < truth.size(); ++i) {
        squares += std::pow(values[i] - truth[i], 2);
        worst = larger(worst, std::fabs(values[i] - truth[i]));
      }
      const double rms = std::sqrt(squares / static_cast<double>(truth.size()));
      std::cout << n[0] << " x " << n[1] << " x " << n[2] << ", across "
                << "xyzt"[axis] << ": RMS " << rms << ", worst " << worst << " of 100\n";
      EXPECT_LT(worst, 0.8) << axis;
    }
  }
}

// A file opened in another shape: its affine, its points and what is read at them are of that world.
TEST(ShapesOfVolumes, AreThoseThatTheyAreOpenedIn) {
  const Device device = make_device();
  const Folder folder;
  const Volume plain = stored(device, folder, {12, 10, 8});
  auto o = sized<bccsplat_volume_options>();
  o.shape[0] = 1, o.shape[1] = 3, o.shape[2] = 0.25;
  const std::string path = folder.file("s.bcc4");
  bccsplat_volume* opened = nullptr;
  ASSERT_OK(bccsplat_volume_open_file(device.get(), path.c_str(), &o, &opened));
  const Volume shaped(opened);
  const double index[] = {5, 4, 3};
  double there[4] = {0, 0, 0, 2}, here[4] = {0, 0, 0, 2}; // at a time
  ASSERT_OK(bccsplat_volume_index_to_world(plain.get(), 1, index, there));
  ASSERT_OK(bccsplat_volume_index_to_world(shaped.get(), 1, index, here));
  for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(here[a], o.shape[a] * there[a], 1e-9);
  float expected = 0, value = 0;
  uint64_t missing = 0;
  ASSERT_OK(bccsplat_volume_evaluate_world(plain.get(), 0, 1, there, &expected, nullptr, &missing));
  ASSERT_OK(bccsplat_volume_evaluate_world(shaped.get(), 0, 1, here, &value, nullptr, &missing));
  EXPECT_GT(expected, 1);
  EXPECT_EQ(value, expected);
  const Slice slice = cut_time(shaped, 2);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
  EXPECT_NEAR(info.affine[5] / info.affine[0], 3 * 11.0 / 9, 1e-9);
  EXPECT_NEAR(info.affine[10] / info.affine[0], 0.25 * 11.0 / 7, 1e-9);
  // So they are in a scene.
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device.get(), &created));
  const Handle<bccsplat_scene> scene(created);
  const auto instance = sized<bccsplat_instance>();
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, shaped.get(), &instance, &id));
  double bounds[6];
  ASSERT_OK(bccsplat_scene_get_bounds(created, bounds));
  for (size_t a = 0; a < 3; ++a)
    EXPECT_NEAR(bounds[3 + a] - bounds[a], info.affine[5 * a] * static_cast<double>(info.dims[a] - 1), 1e-6)
        << a;
  for (const double wrong : {-1.0, 0.0, 1e31, static_cast<double>(NAN)}) {
    o.shape[1] = wrong;
    opened = nullptr;
    EXPECT_EQ(bccsplat_volume_open_file(device.get(), path.c_str(), &o, &opened),
              BCCSPLAT_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(opened, nullptr);
  }
}

} // namespace
} // namespace host
