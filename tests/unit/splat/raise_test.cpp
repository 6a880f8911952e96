// SPDX-License-Identifier: Apache-2.0
// Sheets of fewer samples than pixels: the filter, its loops, and pictures drawn through them.
#include "splat/raise/raise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>
#include <random>

#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using namespace test;

TEST(Raise, WeightsReproduceConstantsAndAreSymmetric) {
  for (const int taps : {4, 6, 8})
    for (const double phase : {0.0, 0.1, 0.37, 0.5}) {
      std::array<double, most_taps> w{}, mirrored{};
      raise_weights(taps, 0.33, phase, w.data());
      raise_weights(taps, 0.33, 1 - phase, mirrored.data());
      double sum = 0;
      for (int t = 0; t < taps; ++t) {
        sum += w[t];
        EXPECT_NEAR(w[t], mirrored[taps - 1 - t], 1e-9);
      }
      EXPECT_NEAR(sum, 1, 1e-12);
    }
}

// Returns the largest error of a wave of `cycles` per T, of amplitude 1, over all phases.
double wave_error(int taps, double density, double cycles) {
  double most = 0;
  for (int p = 0; p <= 32; ++p) {
    std::array<double, most_taps> w{};
    raise_weights(taps, 0.5 / density, p / 32.0, w.data());
    std::complex<double> sum = 0;
    for (int t = 0; t < taps; ++t)
      sum +=
          w[t] * std::polar(1.0, 2 * std::numbers::pi * cycles / density * (t - (taps / 2 - 1) - p / 32.0));
    most = larger(most, std::abs(sum - 1.0));
  }
  return most;
}

TEST(Raise, WavesInsideTheBandComeOutAsTheyWere) {
  for (const double cycles : {0.05, 0.1, 0.2, 0.3, 0.4}) {
    EXPECT_LT(wave_error(6, 1.49, cycles), 0.009) << cycles;
    EXPECT_LT(wave_error(8, 1.49, cycles), 0.003) << cycles;
    EXPECT_LT(wave_error(8, 1.99, cycles), 0.0004) << cycles;
  }
  EXPECT_LT(wave_error(6, 1.49, 0.1), 0.0025);
  EXPECT_LT(wave_error(6, 1.49, 0.5), 0.12); // the edge of the band, where kernels leave little
}

TEST(Raise, LoopsAgreeOnEveryTarget) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (const int taps : {4, 6, 8})
    for (const double ratio : {0.61, 0.8, 1.0, 1.37, 2.9, 17.0}) {
      const int first = 40, width = 61, height = 37; // of the tile in the picture
      const RaiseAxis x = make_raise_axis(ratio, 1.49, taps, -2, 200);
      const RaiseAxis y = make_raise_axis(1.1 * ratio, 1.49, taps, -2, 200);
      const int columns = x.at(first + width - 1) + taps - x.at(first),
                rows = y.at(first + height - 1) + taps - y.at(first), pitch = columns + 32;
      std::vector<float> sheet(static_cast<size_t>(pitch * rows + 32));
      for (float& v : sheet) v = uniform(random);
      std::vector<float> scratch(static_cast<size_t>((pitch + 32) * raise_rows));
      RaiseArgs a;
      a.taps = taps, a.sheet = sheet.data(), a.sheet_pitch = pitch;
      a.plane_pitch = 96, a.x0 = 16, a.x1 = width, a.y0 = 3, a.y1 = height;
      const auto at = [&](const RaiseAxis& axis) { return static_cast<size_t>(first - axis.first); };
      a.sample_x = x.sample.data() + at(x), a.weight_x = x.weight.data() + at(x), a.weight_pitch_x = x.pitch;
      a.sample_y = y.sample.data() + at(y), a.weight_y = y.weight.data() + at(y), a.weight_pitch_y = y.pitch;
      a.origin_x = x.at(first), a.origin_y = y.at(first);
      a.scratch = scratch.data(), a.scratch_pitch = pitch + 32;
      std::vector<float> expected(static_cast<size_t>(96 * height)), got(expected);
      a.plane = expected.data();
      raise_reference(a);
      a.plane = got.data();
      for_targets([&] {
        std::fill(got.begin(), got.end(), 9.0f);
        raise_sheet(a);
        for (int j = a.y0; j < a.y1; ++j)
          for (int i = a.x0; i < a.x1; ++i)
            ASSERT_NEAR(got[96 * j + i], expected[96 * j + i], 2e-6f)
                << taps << " taps, ratio " << ratio << ", " << i << ' ' << j;
      });
    }
}

TEST(Raise, BlendsAgreeOnEveryTarget) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(-1, 1);
  constexpr int pitch = 80, rows = 9;
  std::array<std::vector<float>, most_taps> plane;
  BlendArgs a;
  for (size_t t = 0; t < most_taps; ++t) {
    for (int n = 0; n < pitch * rows + 16; ++n) plane[t].push_back(uniform(random));
    a.plane[t] = plane[t].data(), a.weight[t] = uniform(random);
  }
  a.pitch = pitch, a.out_pitch = 96, a.x0 = 16, a.x1 = 71, a.y0 = 2, a.y1 = rows;
  std::vector<float> expected(96 * rows), got(96 * rows);
  for (a.taps = 1; a.taps <= most_taps; ++a.taps) {
    a.out = expected.data();
    blend_reference(a);
    a.out = got.data();
    for_targets([&] {
      blend_planes(a);
      for (int y = a.y0; y < a.y1; ++y)
        for (int x = a.x0; x < a.x1; ++x) ASSERT_NEAR(got[96 * y + x], expected[96 * y + x], 2e-6f);
    });
  }
}

struct Magnified {
  Slice slice = make_slice({26, 24, 28}, marschner_lobb(28, 3));
  Scene scene;
  explicit Magnified(bool perspective, const Affine3& affine = {})
      : slice(make_slice({26, 24, 28}, marschner_lobb(28, 3), "default", affine)) {
    scene = make_scene(slice, ramp_function(0.3, 1, 0.5), fit_camera(slice, perspective, 20, 30, 150, 140));
  }
  Magnified(const Magnified&) = delete;
  Magnified& operator=(const Magnified&) = delete;
};

// Filters that raise side by side, along the normal, too, or along it only.
constexpr RaiseFilter six{6, 1.49, 1.1, 1.1}, eight{8, 1.99, 1.1, 1.1, 2}, deep{8, 1.99, 1e30, 1e30, 2, 1e30},
    no_fan{6, 1.49, 1.1, 1.1, 0, 1e30}, none{};

// Returns the root of the mean square difference of two pictures.
double difference(const ImageStorage& a, const ImageStorage& b) {
  double sum = 0;
  for (size_t n = 0; n < a.rgba.size(); ++n) sum += std::pow(static_cast<double>(a.rgba[n]) - b.rgba[n], 2);
  return std::sqrt(sum / static_cast<double>(a.rgba.size()));
}

TEST(Raise, PicturesAreThoseOfSheetsAtThePixels) {
  Affine3 sheared;
  sheared.linear = {Vec3{1, 0, 0}, Vec3{0, 1.2, 0.2}, Vec3{0, 0, 1.4}};
  for (const bool perspective : {false, true})
    for (const Affine3& affine : {Affine3{}, sheared}) {
      const Magnified m(perspective, affine);
      for (const RenderMode mode : {RenderMode::composite, RenderMode::xray, RenderMode::maximum}) {
        RenderOptions o;
        o.mode = mode, o.shading = false, o.opacity_stop = 1;
        ImageStorage raised(150, 140), direct(150, 140);
        o.raise = six;
        const RenderStats few = draw(m.scene, o, raised);
        o.raise = none;
        const RenderStats many = draw(m.scene, o, direct);
        EXPECT_LT(few.drawn.contributions, many.drawn.contributions * 4 / 5); // fewer samples, indeed
        // X-rays are lengths, of up to 40 T.
        EXPECT_LT(difference(raised, direct), mode == RenderMode::xray ? 4e-3 : 7e-4)
            << static_cast<int>(mode) << perspective;
        EXPECT_GT(difference(raised, direct), 1e-7);
      }
    }
}

TEST(Raise, LatticesThatStandSkewInThePictureHaveTheSamplesTheirWavesNeed) {
  // Distances of 0.5 and 1.5 samples along the diagonals of the picture.
  const Slice slice = make_slice({26, 26, 12},
                                 [](double x, double y, double z) {
                                   return 0.5 + 0.4 * std::sin(4.1 * x) * std::cos(0.9 * y + 0.2 * z);
                                 },
                                 "default", {}, 0, LatticeKind::bcc, {0.5, 1.5, 1, 1});
  for (const bool perspective : {false, true}) {
    Scene scene =
        make_scene(slice, ramp_function(0.3, 1, 0.5), fit_camera(slice, perspective, 0, 0, 260, 260));
    scene.camera.up = {1, 1, 0};
    RenderOptions o;
    o.shading = false, o.opacity_stop = 1;
    ImageStorage raised(260, 260), direct(260, 260);
    o.raise = six;
    const RenderStats few = draw(scene, o, raised);
    o.raise = none;
    const RenderStats many = draw(scene, o, direct);
    EXPECT_LT(few.drawn.contributions, many.drawn.contributions * 4 / 5);
    EXPECT_LT(difference(raised, direct), 3e-3) << perspective;
  }
}

TEST(Raise, CloseSheetsAreThoseOfTheRing) {
  for (const auto& [filter, perspective] : {std::pair{eight, false}, {deep, false}, {eight, true}})
    for (const bool shading : {false, true})
      for (const double step : {0.25, 0.1}) {
        const Magnified m(perspective);
        RenderOptions o;
        o.shading = shading, o.opacity_stop = 1, o.sheet_step = step;
        o.gradient = GradientMethod::fourth_order, o.kernel_form = KernelForm::flat_form;
        ImageStorage raised(150, 140), direct(150, 140);
        o.raise = filter;
        const RenderStats few = draw(m.scene, o, raised);
        o.raise = none;
        const RenderStats many = draw(m.scene, o, direct);
        EXPECT_LT(few.drawn.contributions, many.drawn.contributions * 2 / 3);
        EXPECT_EQ(few.drawn.sheets, many.drawn.sheets);
        EXPECT_LT(difference(raised, direct), shading ? 5e-3 : 2e-4) << step << shading;
        EXPECT_GT(difference(raised, direct), 1e-7);
      }
}

TEST(Raise, NeitherThreadsNorTilesChangeABit) {
  for (const auto& [filter, step, perspective, mode] : {std::tuple{six, 0.5, false, RenderMode::composite},
                                                        {six, 0.5, true, RenderMode::composite},
                                                        {no_fan, 0.5, true, RenderMode::composite},
                                                        {six, 0.5, true, RenderMode::isosurface},
                                                        {eight, 0.25, true, RenderMode::composite},
                                                        {six, 0.5, false, RenderMode::isosurface},
                                                        {eight, 0.25, false, RenderMode::composite},
                                                        {deep, 0.2, false, RenderMode::composite},
                                                        {eight, 0.25, false, RenderMode::isosurface}}) {
    const Magnified m(perspective);
    RenderOptions o;
    o.rays = false;
    o.mode = mode, o.iso_value = 0.5, o.raise = filter, o.sheet_step = step;
    o.tile_size = 64;
    ImageStorage first(150, 140, true, true, true);
    draw(m.scene, o, first, 1);
    for (const auto& [tile, threads] : {std::pair{64, 3}, {9, 1}, {23, 2}, {200, 2}, {0, 4}}) {
      o.tile_size = tile;
      ImageStorage other(150, 140, true, true, true);
      draw(m.scene, o, other, threads);
      EXPECT_EQ(std::memcmp(first.rgba.data(), other.rgba.data(), first.rgba.size() * sizeof(float)), 0)
          << "tile " << tile << " threads " << threads;
    }
  }
}

TEST(Raise, SurfacesAreThoseOfTheReference) {
  const Magnified m(false);
  ImageStorage exact(150, 140), raised(150, 140);
  RenderOptions o;
  o.rays = false;
  o.mode = RenderMode::isosurface, o.iso_value = 0.5;
  const RenderStats few = draw(m.scene, o, raised);
  o.raise = none;
  const RenderStats many = draw(m.scene, o, exact);
  EXPECT_LT(few.drawn.contributions, many.drawn.contributions * 4 / 5);
  o.reference = true;
  draw(m.scene, o, exact);
  EXPECT_LT(difference(raised, exact), 1e-2); // 40 dB
}

TEST(Raise, SkipsChangeNothing) {
  const Slice slice = make_slice({48, 48, 48}, [](double x, double y, double z) {
    return 1 / (1 + std::exp(2 * (std::hypot(x - 23, y - 23, z - 23) - 12)));
  });
  TransferFunction f = ramp_function(0, 1, 0.95);
  f.opacities = {{0.5, 0}, {0.6, 0.95}};
  const Scene orthographic = make_scene(slice, f, fit_camera(slice, false, 20, 30, 200, 200)),
              perspective = make_scene(slice, f, fit_camera(slice, true, 20, 30, 200, 200));
  for (const auto& [view, filter, step, mode] : {std::tuple{&orthographic, six, 0.5, RenderMode::composite},
                                                 {&orthographic, six, 0.5, RenderMode::isosurface},
                                                 {&orthographic, eight, 0.25, RenderMode::composite},
                                                 {&orthographic, deep, 0.25, RenderMode::composite},
                                                 {&perspective, six, 0.5, RenderMode::composite},
                                                 {&perspective, six, 0.5, RenderMode::isosurface},
                                                 {&perspective, eight, 0.25, RenderMode::composite}}) {
    const Scene& scene = *view;
    RenderOptions o;
    o.rays = false;
    o.mode = mode, o.iso_value = 0.5, o.raise = filter, o.sheet_step = step;
    o.tile_size = 40;
    ImageStorage all(200, 200, true, true, true);
    const RenderStats skipped = draw(scene, o, all);
    EXPECT_GT(skipped.drawn.points_occluded, 0u);
    // Rays that lean, raised in depth, too, look further than cells know.
    if (view == &orthographic || filter.depth == 0) {
      EXPECT_GT(skipped.drawn.points_invisible, 0u);
    }
    for (const uint32_t bit : {1u, 2u, 4u, 8u, 64u, 79u}) {
      o.disable_skips = bit;
      ImageStorage other(200, 200, true, true, true);
      draw(scene, o, other);
      EXPECT_EQ(std::memcmp(all.rgba.data(), other.rgba.data(), all.rgba.size() * sizeof(float)), 0)
          << "skip " << bit << " mode " << static_cast<int>(mode);
    }
  }
}

} // namespace
} // namespace bccsplat
