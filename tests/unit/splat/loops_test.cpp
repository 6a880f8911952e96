// SPDX-License-Identifier: Apache-2.0
// Every SIMD target that this machine has is compared with the reference loops.
#include "splat/loop/loops.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <random>

#include "base/aligned.h"
#include "splat/plan/plan.h"
#include "splat/sheet/sheet.h"
#include "splat/splat.h"
#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using namespace test;

struct SplatCase {
  const char* name;
  const char* kernel;
  bool isotropic, gradient;
  int sheets;
  double pixels; // per lattice unit
  bool spare = false;
  KernelForm form = KernelForm::exact;
};

class SplatLoop : public testing::TestWithParam<SplatCase> {};
INSTANTIATE_TEST_SUITE_P(
    Loops, SplatLoop,
    testing::Values(
        SplatCase{"isotropic", "default", true, false, 4, 1.1},
        SplatCase{"isotropic_gradient", "default", true, true, 8, 2.3},
        SplatCase{"general", "radial18+b3", false, false, 4, 1.7},
        SplatCase{"general_gradient", "fine", false, true, 12, 0.8},
        SplatCase{"gauss", "gauss09", true, false, 8, 1},
        SplatCase{"gauss_gradient", "paper", false, true, 8, 2},
        SplatCase{"large", "default", true, true, 4, 17},
        SplatCase{"large_general", "default", false, false, 16, 9},
        SplatCase{"small", "default", true, false, 8, 1, true},
        SplatCase{"small_pair", "fine", true, false, 4, 1.2, true},
        SplatCase{"blocks_gradient", "radial18+b3", true, true, 4, 1.3},
        SplatCase{"short_small", "default", true, false, 4, 1, true, KernelForm::short_form},
        SplatCase{"short_blocks", "default", true, false, 8, 1.3, false, KernelForm::short_form},
        SplatCase{"short_gradient", "default", true, true, 4, 1.3, false, KernelForm::short_form},
        SplatCase{"short_large", "default", true, false, 8, 4, false, KernelForm::short_form},
        SplatCase{"short_general", "default", false, false, 4, 3, false, KernelForm::short_form},
        SplatCase{"short_general_gradient", "default", false, true, 4, 2, false, KernelForm::short_form},
        SplatCase{"flat_small", "default", true, false, 8, 1, true, KernelForm::flat_form},
        SplatCase{"flat_small_five", "default", true, false, 4, 1.15, true, KernelForm::flat_form},
        SplatCase{"flat_small_six", "default", true, false, 8, 1.49, true, KernelForm::flat_form},
        SplatCase{"flat_blocks", "default", true, false, 4, 2.3, false, KernelForm::flat_form},
        SplatCase{"flat_gradient", "default", true, true, 4, 1.3, false, KernelForm::flat_form},
        SplatCase{"flat_general", "default", false, true, 4, 2, false, KernelForm::flat_form}),
    [](const auto& instance) { return instance.param.name; });

TEST_P(SplatLoop, AddsWhatTheFormulaSays) {
  const SplatCase& c = GetParam();
  const RadialKernel phi = make_kernel(c.kernel).space;
  const KernelPolynomial kernel = kernel_polynomial(phi, c.form);
  ASSERT_EQ(kernel.form == KernelPolynomial::Form::short_form, c.form == KernelForm::short_form);
  ASSERT_EQ(kernel.form == KernelPolynomial::Form::flat_form, c.form == KernelForm::flat_form);
  std::mt19937 random(7);
  const auto uniform = [&](double a, double b) {
    return static_cast<float>(std::uniform_real_distribution<double>(a, b)(random));
  };

  const double radius = phi.radius * c.pixels, step = 2 * phi.radius / (c.sheets - 0.5);
  std::vector<float> lanes(6 * static_cast<size_t>(c.sheets));
  const float metric = static_cast<float>(1 / (radius * radius));
  for (int slot = 0; slot < c.sheets; ++slot) {
    const size_t n = slot, size = c.sheets;
    lanes[n] = static_cast<float>((slot + 3) % c.sheets - c.sheets / 2 + 1);
    lanes[size + n] = c.isotropic ? 0 : 0.01f * lanes[n];
    lanes[2 * size + n] = c.isotropic ? metric : metric * (1 + 0.02f * lanes[n]);
    lanes[3 * size + n] = c.isotropic ? 0 : 0.4f * metric;
    lanes[4 * size + n] = c.isotropic ? metric : 1.3f * metric;
    lanes[5 * size + n] =
        lanes[2 * size + n] - lanes[3 * size + n] * lanes[3 * size + n] / (4 * lanes[4 * size + n]);
  }
  const size_t s = c.sheets;
  const float* l = lanes.data();
  const GapLanes table{l, l + s, l + 2 * s, l + 3 * s, l + 4 * s, l + 5 * s};

  SplatArgs args;
  const int spare = c.spare ? 12 : 0; // rows and columns around the ring
  args.width = 29, args.height = 23, args.pitch = 32 + 8 + 2 * spare;
  args.groups = c.sheets / 4;
  args.group_floats = static_cast<size_t>(args.pitch * (args.height + 2 * spare) * 4) + 64;
  args.spare = c.spare;
  args.lanes = &table, args.kernel = &kernel;
  args.depth2 = static_cast<float>(step * step / (phi.radius * phi.radius));
  args.isotropic = c.isotropic;
  // Windows without spare room are larger than they need be.
  args.columns = args.rows =
      static_cast<int>(std::ceil(2 * radius * (c.spare ? 1 : 1.15)) + (c.spare ? 0 : 0.4 * c.sheets + 2));
  args.half = static_cast<float>(radius);
  std::vector<SplatRecord> records;
  for (int n = 0; n < 60; ++n) {
    const auto centre = static_cast<float>(0.5 * args.columns - 1);
    records.push_back({centre + uniform(0, 1), centre + uniform(0, 1), uniform(0, 1), uniform(-1, 1),
                       static_cast<int>(uniform(-args.columns + 1, args.width)),
                       static_cast<int>(uniform(-args.rows + 1, args.height)),
                       c.isotropic ? 0 : uniform(-20, 20), c.isotropic ? 0 : uniform(-20, 20)});
  }
  args.record = records.data(), args.count = records.size();

  const size_t floats = args.group_floats * args.groups + 96;
  const size_t origin = 16 + 4 * (spare * args.pitch + spare);
  const auto run = [&](void (*splat)(const SplatArgs&)) {
    std::array<AlignedArray<float>, 4> memory;
    std::array<std::vector<float>, 4> ring;
    for (size_t q = 0; q < (c.gradient ? 4u : 1u); ++q) {
      memory[q].reserve(floats);
      std::fill_n(memory[q].data(), floats, 0.0f);
      args.ring[q] = memory[q].data() + origin;
    }
    splat(args);
    for (size_t q = 0; q < (c.gradient ? 4u : 1u); ++q)
      ring[q].assign(memory[q].data(), memory[q].data() + floats);
    return ring;
  };
  const auto expected = run(reference_loops().splat);
  double most = 0;
  for (const float v : expected[0]) most = std::max(most, std::fabs(static_cast<double>(v)));
  ASSERT_GT(most, 0.2 * phi.value(0));
  for_targets([&] {
    const auto got = run(simd_loops().splat);
    for (size_t q = 0; q < (c.gradient ? 4u : 1u); ++q) {
      double scale = 0, error = 0;
      for (int g = 0; g < args.groups; ++g)
        for (int y = 0; y < args.height; ++y)
          for (int x = 0; x < args.width * 4; ++x) { // not the spare pixels
            const size_t at = origin + g * args.group_floats + (y * args.pitch * 4 + x);
            scale = std::max(scale, std::fabs(static_cast<double>(expected[q][at])));
            error = larger(error, std::fabs(static_cast<double>(expected[q][at]) - got[q][at]));
          }
      EXPECT_LT(error, 4e-6 * scale) << "quantity " << q;
    }
  });
}

TEST(Loops, ExtractTakesOneLaneAndClearsIt) {
  const int width = 37, height = 5, pitch = 48 + 8;
  for (int lane = 0; lane < 4; ++lane) {
    for_targets([&] {
      std::vector<float> ring(static_cast<size_t>(pitch * height * 4) + 128), plane(64 * height);
      for (size_t n = 0; n < ring.size(); ++n) ring[n] = static_cast<float>(n);
      const auto before = ring;
      ExtractArgs e{ring.data() + 16, lane, pitch, width, height, plane.data(), 64};
      simd_loops().extract(e);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          for (int l = 0; l < 4; ++l) {
            const size_t at = 16 + (y * pitch + x) * 4 + l;
            ASSERT_EQ(ring[at], l == lane ? 0 : before[at]);
            if (l == lane) {
              ASSERT_EQ(plane[y * 64 + x], before[at]);
            }
          }
    });
  }
}

// A picture is the same on every target and with the reference loops, up to rounding.
TEST(Loops, PicturesAgreeOnEveryTarget) {
  const Slice slice = make_slice({24, 20, 22}, marschner_lobb(24, 2));
  TestContext context(1);
  const SplatPoints points = make_points(slice, context.get());
  Lights lights;
  lights.lights = {Light{}, Light{{1, 2, -1}, {0.3, 0.4, 0.5}}};
  for (const double shininess : {20.0, 7.5})
    for (const bool perspective : {false, true})
      for (const auto mode : {RenderMode::composite, RenderMode::xray, RenderMode::maximum}) {
        lights.shininess = shininess;
        lights.noise = shininess == 20 ? GradientNoise{} : GradientNoise{0.01, 0.05};
        const SheetView view =
            make_view(slice, resolve_camera(fit_camera(slice, perspective, 20, 30, 50, 40)), 50, 40, 0.5);
        const ClassTable table =
            make_class_table(ramp_function(0.3, 1, 0.6), slice.bounds[0], slice.bounds[1], 0, 1, 2048);
        const SplatScene scene{&slice, &points, &view, &table, &lights};
        SplatOptions o;
        o.mode = mode;
        o.shading = mode == RenderMode::composite;
        o.gradient = !perspective      ? GradientMethod::analytic
                     : shininess == 20 ? GradientMethod::central
                                       : GradientMethod::fourth_order;
        o.without_ripple = shininess != 20;
        o.with_value = o.with_time = true;
        if (perspective && shininess != 20) {
          o.raise = RaiseFilter{6, 1, 1, 1, 0, 1};
          DrawStats unused;
          ASSERT_GT(make_plan(scene, o, context.get(), unused).raise.fan.taps, 0);
        }
        const auto draw_planes = [&] {
          std::vector<float> out(5 * 50 * 40);
          splat(scene, o, context.get(), [&](const TilePixels& t) {
            for (int y = 0; y < t.height; ++y)
              for (int x = 0; x < t.width; ++x) {
                const float* planes[] = {t.red, t.alpha, t.depth, t.value, t.time};
                for (size_t q = 0; q < 5; ++q)
                  out[q * 2000 + ((t.y + y) * 50 + t.x + x)] = planes[q][y * t.pitch + x];
              }
          });
          return out;
        };
        o.reference_loops = true;
        const auto expected = draw_planes();
        o.reference_loops = false;
        for_targets([&] {
          const auto got = draw_planes();
          double sum[5] = {}, most[5] = {};
          for (size_t n = 0; n < got.size(); ++n) {
            ASSERT_EQ(std::isfinite(got[n]), std::isfinite(expected[n])) << n;
            if (!std::isfinite(got[n])) continue;
            const double e = std::fabs(static_cast<double>(got[n]) - expected[n]);
            sum[n / 2000] += e / 2000, most[n / 2000] = larger(most[n / 2000], e);
          }
          // A value at the edge of a table entry may fall on either side; gradients near zero may turn.
          for (size_t q = 0; q < 5; ++q) {
            EXPECT_LT(sum[q], 1e-4) << "plane " << q;
            if (!(q == 2 &&
                  mode == RenderMode::maximum)) { // the sheet of equal maxima is a matter of rounding
              EXPECT_LT(most[q], 0.02) << "plane " << q;
            }
          }
        });
      }
}

// Surfaces seen at cosines whose powers are no normal floats have no highlight, and nothing underflows.
TEST(Loops, LightThatGrazesDoesNotUnderflow) {
  ClassTable table;
  table.entry = {{1, 1, 1, 1}};
  index_visible(table);
  std::vector<float> planes(16 * 11, 0.0f), value(48, 0.0f), across(48, 0.5f), along(48);
  for (int n = 0; n < 48; ++n) along[n] = 0.5f * std::pow(10.0f, -static_cast<float>(n % 16) / 3);
  float* p = planes.data();
  Lights lights;
  lights.lights = {Light{}, Light{{0, 1, 1}, {1, 1, 1}}};
  SheetArgs s{.tile = {.width = 16, .height = 1, .pitch = 16, .plane_pitch = 48},
              .field = {.value = value.data() + 16},
              .analytic = {.i = across.data() + 16, .j = value.data() + 16, .k = along.data() + 16},
              .basis = {.x = {1, 0, 0}, .y = {0, 1, 0}, .z = {0, 0, 1}},
              .classes = {.table = &table, .stop = 2},
              .shading = {.on = true, .to_viewer = {0, 0, 1}, .lights = &lights},
              .pixel = {.red = p,
                        .green = p + 16,
                        .blue = p + 32,
                        .alpha = p + 48,
                        .depth = p + 64,
                        .enter = p + 80,
                        .leave = p + 96,
                        .path = p + 112,
                        .view_x = p + 128,
                        .view_y = p + 128,
                        .view_z = p + 144}};
  std::fill_n(p + 80, 16, -10.0f), std::fill_n(p + 96, 16, 10.0f), std::fill_n(p + 112, 16, 1.0f);
  std::fill_n(p + 144, 16, 1.0f);
  for (const double shininess : {0.5, 7.5, 20.0, 50.0}) // whose powers doubles hold
    for (const bool alike : {false, true}) {
      lights.shininess = shininess, s.shading.alike = alike;
      const auto draw = [&](const SheetLoops& loops) {
        std::fill_n(p, 80, 0.0f);
        loops.composite({&s, 1});
        return std::vector<float>(p, p + 16);
      };
      const auto expected = draw(reference_sheet_loops());
      for_targets([&] {
        std::feclearexcept(FE_ALL_EXCEPT);
        const auto got = draw(simd_sheet_loops());
        EXPECT_FALSE(std::fetestexcept(FE_UNDERFLOW)) << shininess << " " << alike;
        for (size_t n = 0; n < 16; ++n) EXPECT_NEAR(got[n], expected[n], 1e-5) << n;
      });
    }
}

// Segments that add more than lit_in_halves are lit by two gradients, in every target as in the reference.
TEST(Loops, DenseSegmentsAreLitInHalves) {
  constexpr int pitch = 48, rows = 5, middle = 2 * pitch + 16;
  ClassTable table;
  table.entry.resize(1);
  index_visible(table);
  std::mt19937 random(7);
  std::normal_distribution<float> noise;
  std::array<std::vector<float>, 5> sheet; // k - 2 to k + 2
  for (auto& plane : sheet) {
    plane.resize(size_t{pitch} * rows);
    for (float& v : plane) v = noise(random);
  }
  std::vector<float> planes(16 * 11, 0.0f);
  float* p = planes.data();
  Lights lights;
  lights.lights = {Light{}, Light{{0, 1, 1}, {1, 0.5, 1}}};
  SheetArgs s{.tile = {.width = 16, .height = 1, .pitch = 16, .plane_pitch = pitch},
              .field = {.value = sheet[2].data() + middle},
              .differences = {.neighbours = 2,
                              .before = sheet[1].data() + middle,
                              .after = sheet[3].data() + middle,
                              .before2 = sheet[0].data() + middle,
                              .after2 = sheet[4].data() + middle,
                              .depth_scale = 0.66f,
                              .depth_scale2 = -0.08f},
              .basis = {.x = {1, 0, 0}, .y = {0, 1, 0}, .z = {0, 0, 1}, .slant_x = 0.1f, .slant_y = -0.2f},
              .classes = {.table = &table, .stop = 2},
              .shading = {.on = true, .to_viewer = {0, 0, 1}, .lights = &lights},
              .pixel = {.red = p,
                        .green = p + 16,
                        .blue = p + 32,
                        .alpha = p + 48,
                        .depth = p + 64,
                        .enter = p + 80,
                        .leave = p + 96,
                        .path = p + 112,
                        .view_x = p + 128,
                        .view_y = p + 128,
                        .view_z = p + 144}};
  std::fill_n(p + 80, 16, -10.0f), std::fill_n(p + 96, 16, 10.0f), std::fill_n(p + 112, 16, 1.0f);
  std::fill_n(p + 144, 16, 1.0f);
  const auto draw = [&](const SheetLoops& loops, bool halves) {
    std::fill_n(p, 80, 0.0f);
    s.differences.halves = halves;
    loops.composite({&s, 1});
    return std::vector<float>(p, p + 48);
  };
  for (const float extinction : {0.01f, 0.03f, 0.5f, 4.0f})
    for (const bool alike : {false, true}) {
      table.entry = {{0.9f, 0.8f, 0.7f, extinction}};
      index_visible(table);
      s.shading.alike = alike;
      const auto expected = draw(reference_sheet_loops(), true), whole = draw(reference_sheet_loops(), false);
      EXPECT_EQ(expected == whole, extinction < lit_in_halves);
      for_targets([&] {
        const auto got = draw(simd_sheet_loops(), true);
        for (size_t n = 0; n < got.size(); ++n)
          EXPECT_NEAR(got[n], expected[n], 2e-6) << n << ' ' << extinction << ' ' << alike;
      });
    }
}

TEST(Loops, AbsorptionIsExactForThinAndThickSegments) {
  // The law of absorption goes through the composite loop, as one sheet of extinction x.
  ClassTable table;
  for (const float x : {0.0f, 1e-7f, 1e-5f, 0.01f, 0.3f, 0.7f, 3.0f, 20.0f, 1e9f}) {
    table.entry = {{1, 1, 1, x}};
    index_visible(table);
    std::vector<float> planes(16 * 11, 0.0f), value(48, 0.0f);
    float* p = planes.data();
    std::fill_n(p + 80, 16, -10.0f), std::fill_n(p + 96, 16, 10.0f), std::fill_n(p + 112, 16, 1.0f);
    const SheetArgs s{.tile = {.width = 16, .height = 1, .pitch = 16, .plane_pitch = 48},
                      .field = {.value = value.data() + 16},
                      .classes = {.table = &table, .stop = 2},
                      .pixel = {.red = p,
                                .green = p + 16,
                                .blue = p + 32,
                                .alpha = p + 48,
                                .depth = p + 64,
                                .enter = p + 80,
                                .leave = p + 96,
                                .path = p + 112,
                                .view_x = p + 128,
                                .view_y = p + 128,
                                .view_z = p + 128}};
    const double exact = -std::expm1(-static_cast<double>(x));
    for_targets([&] {
      std::fill_n(p, 80, 0.0f);
      simd_sheet_loops().composite({&s, 1});
      for (int n = 0; n < 16; ++n) EXPECT_NEAR(p[48 + n], exact, 3e-7 * exact) << x;
    });
  }
}

} // namespace
} // namespace bccsplat
