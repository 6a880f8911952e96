// SPDX-License-Identifier: Apache-2.0
// One moving field over one box, sampled at even places finely, and at uneven ones: pictures of any kind are
// the same, and no picture takes indices for places.
#include <algorithm>
#include <array>
#include <iostream>
#include <limits>

#include "support.h"

namespace host::uneven_pictures {
namespace {

constexpr double edge = 40; // of the box, in world units
constexpr uint32_t pixels = 96, frames = 8, fine = 48;

// A soft ball with stripes that moves, in box edges and frames.
double field_at(double x, double y, double z, double t) {
  const double dx = x - 0.42 - 0.02 * t, dy = y - 0.5, dz = z - 0.35 + 0.015 * t;
  const double stripes = 0.8 + 0.2 * std::cos(9 * x + 6 * y - 8 * z);
  return 100 * stripes * std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * 0.17 * 0.17));
}

// Closer at the beginning, as depths are.
std::vector<double> stretched(uint32_t n, double ratio) {
  std::vector<double> at{0};
  double step = 1;
  for (uint32_t i = 1; i < n; ++i, step *= ratio) at.push_back(at.back() + step);
  for (double& c : at) c *= edge / at.back();
  at.back() = edge;
  return at;
}
// The same from the other end.
std::vector<double> turned(std::vector<double> at) {
  std::reverse(at.begin(), at.end());
  return at;
}

Volume stored(const Device& device, const Folder& folder, const std::array<std::vector<double>, 3>& at,
              bool uneven) {
  Series s{static_cast<uint32_t>(at[0].size()), static_cast<uint32_t>(at[1].size()),
           static_cast<uint32_t>(at[2].size()), frames};
  s.field = [&](double x, double y, double z, double t) {
    return field_at(at[0][static_cast<size_t>(x)] / edge, at[1][static_cast<size_t>(y)] / edge,
                    at[2][static_cast<size_t>(z)] / edge, t);
  };
  auto o = options_of(s);
  std::array<bccsplat_axis, 3> axes{};
  for (size_t a = 0; a < 3; ++a) {
    axes[a] = sized<bccsplat_axis>();
    axes[a].count = at[a].size(), axes[a].coordinates = at[a].data();
    o.affine[5 * a] = (at[a].back() - at[a].front()) / (static_cast<double>(at[a].size()) - 1);
    o.affine[4 * a + 3] = at[a].front();
  }
  o.affine[15] = 1;
  if (uneven) o.axes = axes.data();
  o.overwrite = 1;
  const std::string path = folder.free_file("s.bcc4");
  const Writer w = make_writer(device, path, o);
  EXPECT_OK(add_frames(w.get(), s));
  EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
  return open(device, path);
}

std::vector<double> evenly(uint32_t n) {
  std::vector<double> at;
  for (uint32_t i = 0; i < n; ++i) at.push_back(edge * i / (n - 1.0));
  return at;
}

Slice cut_evenly(const Volume& volume, const std::array<double, 5>& h,
                 bccsplat_slice_options options = sized<bccsplat_slice_options>()) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.a = h[0], plane.b = h[1], plane.c = h[2], plane.d = h[3], plane.e = h[4];
  options.space = BCCSPLAT_SPACE_EVEN;
  bccsplat_slice* s = nullptr;
  EXPECT_OK(bccsplat_slice_create(volume.get(), &plane, &options, &s));
  return Slice(s);
}

struct View {
  const char* name;
  bccsplat_mode mode;
  bccsplat_projection projection;
  double trail; // frames that it goes back
  double least; // dB
};

bccsplat_transfer_function function_of(const double* colors, const double* opacities) {
  auto function = sized<bccsplat_transfer_function>();
  function.color_count = 3, function.opacity_count = 2;
  function.colors = colors, function.opacities = opacities;
  function.unit_distance = 1;
  return function;
}
constexpr double colors[] = {0, 0.1, 0.2, 1, 50, 0.2, 1, 0.3, 100, 1, 0.6, 0.1},
                 opacities[] = {5, 0, 100, 0.3};

Renderer renderer_of(const Device& device, const Slice& slice, const View& view) {
  bccsplat_renderer* r = nullptr;
  EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
  Renderer renderer(r);
  auto options = sized<bccsplat_render_options>();
  options.mode = view.mode, options.quality = BCCSPLAT_QUALITY_NORMAL;
  options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 45;
  EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  EXPECT_OK(bccsplat_renderer_set_options(r, &options));
  const bccsplat_transfer_function function = function_of(colors, opacities);
  EXPECT_OK(bccsplat_renderer_set_transfer_function(r, &function));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -view.trail, trail.samples = 12;
  EXPECT_OK(bccsplat_renderer_set_trail(r, view.trail > 0 ? &trail : nullptr));
  return renderer;
}

std::vector<float> picture(const Device& device, const Slice& slice, const View& view) {
  const Renderer renderer = renderer_of(device, slice, view);
  auto camera = sized<bccsplat_camera>();
  EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), view.projection, 25, 40, pixels, pixels, &camera));
  EXPECT_OK(bccsplat_renderer_set_camera(renderer.get(), &camera));
  std::vector<float> rgba(size_t{pixels} * pixels * 4);
  bccsplat_frame* f = nullptr;
  EXPECT_OK(bccsplat_frame_wrap(device.get(), pixels, pixels, rgba.data(), 0, &f));
  const Frame frame(f);
  EXPECT_OK(bccsplat_renderer_render(renderer.get(), f));
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

struct UnevenPictures : testing::Test {
  Device device = make_device();
  Folder folder;
  Volume even = stored(device, folder, {evenly(fine), evenly(fine), evenly(fine)}, false);
  std::array<std::vector<double>, 3> at{evenly(40), turned(stretched(44, 1.02)), stretched(40, 1.05)};
  Volume uneven = stored(device, folder, at, true);
};

TEST_F(UnevenPictures, AreThoseOfTheField) {
  for (const View& view :
       {View{"composite", BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 45},
        View{"perspective", BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_PROJECTION_PERSPECTIVE, 0, 45},
        View{"X-ray", BCCSPLAT_MODE_XRAY, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 45},
        View{"maximum", BCCSPLAT_MODE_MAXIMUM, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 45},
        View{"isosurface", BCCSPLAT_MODE_ISOSURFACE, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 30},
        View{"trail", BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 3, 45}}) {
    const std::vector<float> truth = picture(device, cut_evenly(even, {0, 0, 0, 1, -4.3}), view);
    const std::vector<float> got = picture(device, cut_evenly(uneven, {0, 0, 0, 1, -4.3}), view);
    const double db = decibels(truth, got);
    std::cout << "  " << view.name << ": " << db << " dB\n";
    EXPECT_GE(db, view.least) << view.name;
  }
}

// Planes over time: x or z = constant, and an oblique one. Even positions of the two volumes differ by the
// number of samples alone.
TEST_F(UnevenPictures, OverTimeAreThoseOfTheField) {
  const View view{"plane", BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 45};
  const auto cut = [&](const Volume& volume, const std::array<double, 3>& n,
                       const std::array<double, 4>& normal, double at_x, double at_y, double at_z) {
    auto options = sized<bccsplat_slice_options>();
    options.time_length = 4;
    // A plane of the world, in even positions: normal (a, b, c) per box edge, d per frame.
    std::array<double, 5> h{normal[0] / (n[0] - 1), normal[1] / (n[1] - 1), normal[2] / (n[2] - 1), normal[3],
                            0};
    h[4] = -(normal[0] * at_x + normal[1] * at_y + normal[2] * at_z + normal[3] * 3.5);
    return cut_evenly(volume, h, options);
  };
  const std::array<double, 3> of_even{fine, fine, fine}, of_uneven{40, 44, 40};
  for (const std::array<double, 4>& normal :
       {std::array<double, 4>{1, 0, 0, 0}, std::array<double, 4>{0, 0, 1, 0},
        std::array<double, 4>{0.8, 0, 1, 0.05}}) {
    // y falls: even position 0 of it is at the far end.
    const Slice a = cut(even, of_even, normal, 0.45, 0.5, 0.3),
                b = cut(uneven, of_uneven, normal, 0.45, 0.5, 0.3);
    if (normal[3] != 0) continue; // bases of oblique planes depend on the numbers of samples: compared below
    const double db = decibels(picture(device, a, view), picture(device, b, view));
    std::cout << "  normal " << normal[0] << ' ' << normal[2] << ": " << db << " dB\n";
    EXPECT_GE(db, 45);
  }
  // Values of the oblique one against the field.
  const Slice oblique = cut(uneven, of_uneven, {0.8, 0, 1, 0.05}, 0.45, 0.5, 0.3);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(oblique.get(), &info));
  size_t compared = 0;
  double worst = 0;
  for (double u = 0.05; u < 1; u += 0.06)
    for (double v = 0.05; v < 1; v += 0.06)
      for (double w = 0.05; w < 1; w += 0.06) {
        const std::array<double, 3> share{u, v, w};
        double uvw[3], even_place[4];
        for (size_t k = 0; k < 3; ++k)
          uvw[k] = info.extent[k][0] + share[k] * (info.extent[k][1] - info.extent[k][0]);
        for (size_t i = 0; i < 4; ++i)
          even_place[i] = info.origin[i] + info.basis[0][i] * uvw[0] + info.basis[1][i] * uvw[1] +
                          info.basis[2][i] * uvw[2];
        float value = 0;
        if (bccsplat_slice_evaluate(oblique.get(), 1, uvw, &value, nullptr) != BCCSPLAT_OK) continue;
        const double truth =
            field_at(even_place[0] / 39, 1 - even_place[1] / 43, even_place[2] / 39, even_place[3]);
        worst = larger(worst, std::fabs(value - truth));
        ++compared;
      }
  std::cout << "  oblique: " << compared << " points, at most " << worst << " of 100 off\n";
  EXPECT_GT(compared, 100u);
  EXPECT_LT(worst, 2); // of 100
}

TEST_F(UnevenPictures, OfScenesAreThoseOfTheField) {
  const auto draw = [&](const Volume& volume) {
    bccsplat_scene* made = nullptr;
    EXPECT_OK(bccsplat_scene_create(device.get(), &made));
    const Handle<bccsplat_scene> scene(made);
    const bccsplat_transfer_function function = function_of(colors, opacities);
    auto instance = sized<bccsplat_instance>();
    const double placement[16] = {0, 1, 0, 3, -1, 0, 0, 5, 0, 0, 2, -7, 0, 0, 0, 1};
    std::copy(std::begin(placement), std::end(placement), instance.placement);
    instance.transfer_function = &function;
    uint64_t id = 0;
    EXPECT_OK(bccsplat_scene_add(made, volume.get(), &instance, &id));
    EXPECT_OK(bccsplat_scene_set_time(made, 4.3));
    std::vector<float> rgba(size_t{pixels} * pixels * 4);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), pixels, pixels, rgba.data(), 0, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_scene_render(made, nullptr, f, nullptr, 0, nullptr));
    return rgba;
  };
  const double db = decibels(draw(even), draw(uneven));
  std::cout << "  scene: " << db << " dB\n";
  EXPECT_GE(db, 45);
}

TEST_F(UnevenPictures, OfIndicesAreRefused) {
  const View view{"", BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 0};
  const Slice slice = cut_time(uneven, 4);
  const Renderer renderer = renderer_of(device, slice, view);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 16, 16, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  EXPECT_EQ(bccsplat_renderer_render(renderer.get(), f), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("BCCSPLAT_SPACE_EVEN"), std::string::npos)
      << bccsplat_last_error();
}

TEST_F(UnevenPictures, EvenSlicesOfEvenVolumesAreTheSame) {
  const Slice a = cut_time(even, 4.3), b = cut_evenly(even, {0, 0, 0, 1, -4.3});
  std::vector<float> x(size_t{fine} * fine * fine), y(x.size());
  ASSERT_OK(bccsplat_slice_sample_grid(a.get(), nullptr, x.data()));
  ASSERT_OK(bccsplat_slice_sample_grid(b.get(), nullptr, y.data()));
  EXPECT_EQ(x, y);
}

TEST_F(UnevenPictures, WrongSpacesAndMethodsAreRefused) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -4;
  auto options = sized<bccsplat_slice_options>();
  bccsplat_slice* made = nullptr;
  options.space = 3;
  EXPECT_EQ(bccsplat_slice_create(uneven.get(), &plane, &options, &made), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  options.space = BCCSPLAT_SPACE_EVEN, options.method = BCCSPLAT_METHOD_EXTRACTED;
  EXPECT_EQ(bccsplat_slice_create(uneven.get(), &plane, &options, &made), BCCSPLAT_ERROR_UNSUPPORTED);
}

// What is missing at the source's samples is missing up to half way to the next one, in indices.
TEST(UnevenMasks, AreExactInEvenPositions) {
  const Device device = make_device();
  const Folder folder;
  const std::vector<double> z = stretched(24, 1.1);
  Series s{14, 13, static_cast<uint32_t>(z.size()), 5};
  const auto land = [](double x, double y, double k) { return k > 6 + x / 2 && y < 9; };
  s.field = [&](double x, double y, double k, double t) {
    return land(x, y, k)
               ? std::numeric_limits<double>::quiet_NaN()
               : 10 + std::sin(0.4 * x + 0.2 * t) * std::cos(0.3 * y) + 0.1 * z[static_cast<size_t>(k)];
  };
  auto o = options_of(s);
  std::array<bccsplat_axis, 3> axes{};
  for (auto& a : axes) a = sized<bccsplat_axis>();
  axes[2].count = z.size(), axes[2].coordinates = z.data();
  o.axes = axes.data(), o.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  o.affine[0] = o.affine[5] = o.affine[15] = 1, o.affine[10] = edge / (s.nz - 1.0);
  const Writer w = make_writer(device, folder.file("m.bcc4"), o);
  ASSERT_OK(add_frames(w.get(), s));
  ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
  const Volume volume = open(device, folder.file("m.bcc4"));
  const Slice even = cut_evenly(volume, {0, 0, 0, 1, -2.2}), plane = cut_evenly(volume, {1, 0, 0, 0, -5});
  size_t missing = 0, there = 0;
  for (double x = 0.13; x < 13; x += 0.77)
    for (double y = 0.19; y < 12; y += 0.83)
      for (double k = 0.07; k < 23; k += 0.31) {
        double world[3] = {x, y, k};
        ASSERT_OK(bccsplat_volume_index_to_world(volume.get(), 1, world, world));
        const double uvw[3] = {x, y, world[2] / o.affine[10]};
        float value = 0;
        const bool expected = land(std::floor(x + 0.5), std::floor(y + 0.5), std::floor(k + 0.5));
        const bccsplat_status status = bccsplat_slice_evaluate(even.get(), 1, uvw, &value, nullptr);
        ASSERT_EQ(status, expected ? BCCSPLAT_ERROR_HOLE : BCCSPLAT_OK) << x << ' ' << y << ' ' << k;
        (expected ? missing : there) += 1;
        const double over_time[3] = {y, uvw[2], 2.2}; // y, z and t of the plane x = 5
        const bool of_plane = land(5, std::floor(y + 0.5), std::floor(k + 0.5));
        ASSERT_EQ(bccsplat_slice_evaluate(plane.get(), 1, over_time, &value, nullptr),
                  of_plane ? BCCSPLAT_ERROR_HOLE : BCCSPLAT_OK);
      }
  EXPECT_GT(missing, 1000u);
  EXPECT_GT(there, 1000u);
}

} // namespace
} // namespace host::uneven_pictures
