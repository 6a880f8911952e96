// SPDX-License-Identifier: Apache-2.0
// Pre-integrated classification: against exact integrals, the slow reference and itself.
#include "shade/preintegrate.h"
#include "splat/points/value_change.h"

#include <gtest/gtest.h>

#include <random>

#include "draw/deep.h"
#include "slice/hyperslice.h"
#include "splat/sheet/sheet.h"
#include "tests/support/emulated.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

TransferFunction peak(double value, double half_width, double opacity) {
  TransferFunction f;
  f.colors = {{0, {1, 0.2, 0.1}}, {1, {0.1, 0.4, 1}}};
  f.opacities = {{value - half_width, 0}, {value, opacity}, {value + half_width, 0}};
  return f;
}

TransferFunction shells(std::initializer_list<double> values, double half_width, double opacity) {
  TransferFunction f = peak(0, 1, 0);
  f.opacities.clear();
  for (const double v : values) {
    const auto p = peak(v, half_width, opacity).opacities;
    f.opacities.insert(f.opacities.end(), p.begin(), p.end());
  }
  return f;
}

ClassTable table_of(const TransferFunction& f, double low, double high, int entries) {
  ClassTable t = make_class_table(f, low, high, low, 1, entries);
  t.integrals = integrate_values(f, t);
  return t;
}

// Returns the mean of (colour * extinction, extinction) between two values, in fine steps.
std::array<double, 4> mean_between(const TransferFunction& f, double a, double b) {
  std::array<double, 4> sum{};
  constexpr int steps = 40000;
  for (int n = 0; n < steps; ++n) {
    const double v = a + (n + 0.5) / steps * (b - a), absorbs = extinction(f.opacity(v), 1);
    const Vec3 color = f.color(v);
    for (size_t c = 0; c < 3; ++c) sum[c] += color[c] * absorbs / steps;
    sum[3] += absorbs / steps;
  }
  return sum;
}

TEST(Preintegrate, SegmentsHoldTheExactMeanOfTheFunction) {
  // Steps, peaks narrower than an entry, a ramp; values beyond the ends.
  TransferFunction f = shells({0.2, 0.37}, 0.0004, 0.9);
  f.opacities.insert(f.opacities.end(), {{0.5, 0}, {0.5, 0.3}, {0.6, 0.3}, {0.6, 0.05}, {0.95, 0.6}});
  const ClassTable table = table_of(f, 0, 1, 512);
  const auto entry = [&](double v) { return (static_cast<float>(v) - table.low) * table.scale; };
  for (const auto& [a, b] : {std::pair{0.19, 0.22},
                             {0.1, 0.9},
                             {0.9, 0.1},
                             {0.36, 0.52},
                             {0.55, 0.601},
                             {0.58, 0.7},
                             {0.9, 1.4},
                             {-0.3, 0.25},
                             {0.61, 0.64}}) {
    const auto mean = mean_between(f, a, b);
    const HalfClass s = classify_half(table, entry(a), entry(b), 0.7f);
    // Partly crossed entries hold their mean everywhere: half an entry of what lies between.
    const double part = 0.5 / (511 * std::fabs(b - a));
    EXPECT_NEAR(s.absorbed, -std::expm1(-0.7 * mean[3]), 1e-5 + 0.3 * part) << a << ' ' << b;
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(s.color[c], mean[c] / mean[3], 1e-4 + part) << a << ' ' << b;
  }
  // Nothing is between the peaks, not even rounding.
  EXPECT_EQ(classify_half(table, entry(0.21), entry(0.36), 1).absorbed, 0);
  EXPECT_FALSE(table.integrals.visible(entry(0.21), entry(0.36)));
  EXPECT_TRUE(table.integrals.visible(entry(0.21), entry(0.38)));
}

TEST(Preintegrate, SmallExtinctionsKeepTheirDigitsBesideOpaqueOnes) {
  TransferFunction f = peak(0, 1, 0);
  f.opacities = {{0, 1}, {0.5, 1}, {0.5, 0.01}, {1, 0.01}};
  const ClassTable table = table_of(f, 0, 1, 4096);
  for (const float from : {2100.0f, 3000.0f, 4000.0f}) {
    const HalfClass s = classify_half(table, from, from + 10, 1);
    EXPECT_NEAR(s.absorbed, 0.01, 1e-5) << from;
  }
  EXPECT_EQ(classify_half(table, 0, 4000, 0.5f).absorbed, 1);
  EXPECT_EQ(classify_half(table, 2040, 4000, 0.5f).absorbed, 1); // seven entries of opacity 1
}

// Sheets of a tile whose rays all look alike, as planes of any values.
struct Sheets {
  static constexpr int width = 37, height = 5, pitch = 48;
  static constexpr size_t size = size_t{pitch} * height;
  int count;
  std::vector<std::vector<float>> plane; // from sheet -2 on
  std::vector<float> enter, leave, path, zero;
  std::vector<std::vector<float>> out = std::vector<std::vector<float>>(6, std::vector<float>(size));
  std::vector<uint8_t> hole;
  const ClassTable* table = nullptr;
  float stop = 2;

  explicit Sheets(int sheets)
      : count(sheets), plane(static_cast<size_t>(sheets) + 4, std::vector<float>(size)), enter(size, -0.5f),
        leave(size, static_cast<float>(sheets) - 0.5f), path(size, 0.5f), zero(size), hole(size) {}

  int composite(const SheetLoops& loops, int at_once) {
    for (auto& o : out) std::fill(o.begin(), o.end(), 0.0f);
    int closed = 0;
    for (int k = 0; k < count; k += at_once) {
      std::vector<SheetArgs> batch;
      for (int n = k; n < std::min(k + at_once, count); ++n) batch.push_back(sheet(n));
      closed += loops.composite(batch);
    }
    return closed;
  }
  SheetArgs sheet(int k) {
    const auto at = [&](int n) { return plane[n + 2].data(); };
    constexpr std::array cubic{0.5625f, 0.5625f, -0.0625f, -0.0625f};
    return {.segment = {.k = static_cast<float>(k)},
            .tile = {.width = width, .height = height, .pitch = pitch, .plane_pitch = pitch},
            .field = {.value = at(k)},
            .classes = {.table = table, .stop = stop},
            .halves = {.preintegrated = true,
                       .known = 2,
                       .front = {{at(k), at(k - 1), at(k + 1), at(k - 2)}, cubic},
                       .back = {{at(k), at(k + 1), at(k - 1), at(k + 2)}, cubic}},
            .hole = hole.data(),
            .pixel = {.red = out[0].data(),
                      .green = out[1].data(),
                      .blue = out[2].data(),
                      .alpha = out[3].data(),
                      .depth = out[4].data(),
                      .value = out[5].data(),
                      .enter = enter.data(),
                      .leave = leave.data(),
                      .path = path.data(),
                      .view_x = zero.data(),
                      .view_y = zero.data(),
                      .view_z = zero.data()}};
  }
};

TEST(Preintegrate, LinearRaysHaveTheExactIntegral) {
  // Values that rise by 0.11 per sheet through a box, a peak and an edge narrower than that, and rays that
  // begin and end anywhere inside a segment.
  TransferFunction f = shells({0.31}, 0.01, 0.8);
  f.opacities.insert(f.opacities.end(),
                     {{0.52, 0}, {0.52, 0.4}, {0.55, 0.4}, {0.55, 0}, {0.8, 0}, {0.8, 0.2}});
  const ClassTable table = table_of(f, 0, 1, 4096);
  Sheets s(10);
  s.table = &table;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> cut(0, 4);
  for (size_t p = 0; p < Sheets::size; ++p) {
    s.enter[p] += cut(random), s.leave[p] -= cut(random);
    const float start = -0.02f + 0.01f * static_cast<float>(p % 13);
    for (size_t n = 0; n < s.plane.size(); ++n) s.plane[n][p] = start + 0.11f * (static_cast<float>(n) - 2);
  }
  for (const SheetLoops* loops : {&reference_sheet_loops(), &simd_sheet_loops()}) {
    s.composite(*loops, 4);
    for (int y = 0; y < Sheets::height; ++y)
      for (int x = 0; x < Sheets::width; ++x) {
        const size_t p = static_cast<size_t>(y) * Sheets::pitch + x;
        const double start = s.plane[2][p];
        const double a = start + 0.11 * s.enter[p], b = start + 0.11 * s.leave[p];
        const double depth = mean_between(f, a, b)[3] * 0.5 * (s.leave[p] - s.enter[p]);
        ASSERT_NEAR(s.out[3][p], -std::expm1(-depth), 4e-4) << x << ' ' << y;
      }
  }
}

TEST(Preintegrate, VectorsAreThePlainLoops) {
  TransferFunction f = shells({0.2, 0.4, 0.6}, 0.02, 0.7);
  f.opacities.push_back({0.9, 0}), f.opacities.push_back({0.9, 1});
  const ClassTable table = table_of(f, 0, 1, 1024);
  Sheets s(9);
  s.table = &table;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(-0.1f, 0.97f), cut(-1, 5);
  for (auto& plane : s.plane)
    for (float& v : plane) v = any(random);
  for (size_t p = 0; p < Sheets::size; ++p) {
    s.enter[p] += cut(random), s.leave[p] -= cut(random);
    if (p % 7 == 3) // a ray with little on it
      for (auto& plane : s.plane) plane[p] = 0.05f;
    if (p % 11 == 5 || p % Sheets::pitch >= Sheets::width)
      s.enter[p] = std::numeric_limits<float>::infinity(), s.leave[p] = -s.enter[p];
    s.hole[p] = p % 17 == 1;
  }
  for (const float stop : {2.0f, 0.9f}) {
    s.stop = stop;
    const int closed = s.composite(reference_sheet_loops(), 1);
    const auto expected = s.out;
    for (const int at_once : {1, 4}) {
      EXPECT_EQ(s.composite(simd_sheet_loops(), at_once), closed);
      for (size_t q = 0; q < expected.size(); ++q)
        for (size_t p = 0; p < Sheets::size; ++p) {
          if (p % Sheets::pitch >= Sheets::width) continue;
          ASSERT_NEAR(s.out[q][p], expected[q][p], q == 4 ? 2e-3f : 3e-5f) << q << ' ' << p;
        }
    }
  }
}

RenderOptions flat(double step, Preintegrate preintegrate = Preintegrate::on) {
  RenderOptions o;
  o.shading = false;
  o.sheet_step = step;
  o.opacity_stop = 1;
  o.preintegrate = preintegrate;
  return o;
}

TEST(Preintegrate, ConstantFieldsHaveNoShellsAtTheDomainsFaces) {
  // Sheets look beyond the domain, where the field goes on for a while only: a function that shows values
  // just below the constant must show nothing.
  Affine3 affine;
  affine.linear = {Vec3{1, 0, 0}, Vec3{0, 1.3, 0.2}, Vec3{0, 0, 2}};
  for (const bool perspective : {false, true})
    for (const double step : {0.125, 0.5, 1.0, 1.3, 2.0, 3.0})
      for (const double turn : {0.0, 30.0}) {
        Slice slice = make_slice(
            {12, 9, 11}, [](double, double, double) { return 5; }, "default", affine);
        slice.bounds = {0, 6}; // the table holds the function beyond the values that occur
        TransferFunction f;
        f.colors = {{0, {1, 1, 1}}};
        f.opacities = {{0, 0.9}, {4.8, 0.9}, {4.8, 0}, {5.2, 0}, {5.2, 0.9}};
        const Scene scene = make_scene(slice, f, fit_camera(slice, perspective, turn, turn, 33, 27));
        ImageStorage out(33, 27);
        EXPECT_TRUE(draw(scene, flat(step), out).drawn.preintegrated);
        for (size_t p = 3; p < out.rgba.size(); p += 4)
          ASSERT_EQ(out.rgba[p], 0) << "step " << step << " turn " << turn << ' ' << perspective;
      }
}

TEST(Preintegrate, ObliqueSlicesHaveNoShellsAtTheirEnds) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::bcc, {14, 14, 14, 14});
  const auto samples = sample_field(
      lattice, [](const Vec4&) { return 5; }, 0);
  const Coefficients c(samples, 0, make_kernel("default"), 0, 1u << 30);
  Slice slice = hyperslice(c, {0.4, 0.3, -0.2, 0.8, -8}, {}, {}, context.get());
  slice.bounds = {0, 6};
  TransferFunction f;
  f.colors = {{0, {1, 1, 1}}};
  f.opacities = {{0, 0.9}, {4.7, 0.9}, {4.7, 0}};
  for (const double step : {0.25, 0.5, 1.0}) {
    const Scene scene = make_scene(slice, f, fit_camera(slice, false, 20, 30, 33, 27));
    ImageStorage out(33, 27);
    draw(scene, flat(step), out);
    float most = 0;
    for (size_t p = 3; p < out.rgba.size(); p += 4) most = std::max(most, out.rgba[p]);
    EXPECT_EQ(most, 0) << "step " << step;
    const Scene shown = make_scene(slice, ramp_function(0, 5, 0.5), scene.camera);
    draw(shown, flat(step), out);
    EXPECT_GT(out.image.rgba.at(16, 13)[3], 0.9f);
  }
}

// The picture of a scene, integrated in steps finer than its function.
struct Exact {
  static constexpr int size = 26;
  const Scene& scene;
  ImageStorage image{size, size};
  explicit Exact(const Scene& s) : scene(s) {
    TestContext context(2);
    (void)render_reference(s, flat(1), slice_field(*s.slice), {1.0 / 128}, context.get(), image.image);
  }
  [[nodiscard]] double db(const RenderOptions& options) const {
    ImageStorage got(size, size);
    draw(scene, options, got);
    return compare(image, got).db();
  }
};

TEST(Preintegrate, NarrowFunctionsConvergeFromCoarseSheets) {
  const Slice slice = make_slice({20, 17, 22}, marschner_lobb(20, 2.2));
  for (const bool perspective : {false, true}) {
    const Scene scene = make_scene(slice, shells({0.35, 0.5, 0.65}, 0.015, 0.7),
                                   fit_camera(slice, perspective, 20, 30, Exact::size, Exact::size));
    const Exact exact(scene);
    // The limits are what was measured less about 3 dB.
    const double coarse = exact.db(flat(1)), middle = exact.db(flat(0.5)), fine = exact.db(flat(0.25));
    EXPECT_GT(coarse, 27);
    EXPECT_GT(middle, 40);
    EXPECT_GT(fine, 49);
    EXPECT_GT(fine - coarse, 18); // two halvings
    EXPECT_GT(middle, exact.db(flat(0.5, Preintegrate::off)) + 18);
  }
}

TEST(Preintegrate, ShellsBetweenAirAndTheFirstSampleAreSeen) {
  // A ball that rises from air within a step: most of its shell lies between two sheets.
  const Slice slice = make_slice({32, 32, 32}, [](double x, double y, double z) {
    return 1 / (1 + std::exp(4 * (std::hypot(x - 15.5, y - 15.5, z - 15.5) - 9)));
  });
  const Scene scene =
      make_scene(slice, peak(0.3, 0.02, 0.95), fit_camera(slice, false, 20, 30, Exact::size, Exact::size));
  const Exact exact(scene);
  EXPECT_LT(exact.db(flat(0.5, Preintegrate::off)), 20);
  EXPECT_GT(exact.db(flat(0.5)), 30);
}

TEST(Preintegrate, TheReferenceTakesFinerStepsForNarrowFunctions) {
  const auto step = [](const TransferFunction& f) { return reference_step(f, {-1, 1}); };
  EXPECT_EQ(step(ramp_function(-0.3, 1, 0.9)), 1.0 / 16);
  EXPECT_NEAR(step(peak(0.5, 0.04, 0.2)), 0.02, 1e-12);
  EXPECT_EQ(step(peak(0.5, 0.001, 0.2)), 1.0 / 128);
  TransferFunction f = ramp_function(0, 1, 0.5);
  f.opacities = {{0, 0}, {0.5, 0}, {0.5, 0.3}};
  EXPECT_EQ(step(f), 1.0 / 128);
  f.opacities = {{0, 0}, {1, 0}};
  EXPECT_EQ(step(f), 1.0 / 16);
  f.opacities = {{0, 0.4}};
  EXPECT_EQ(step(f), 1.0 / 16);
  const Slice slice = make_slice({20, 17, 22}, marschner_lobb(20, 2.2));
  const Scene scene = make_scene(slice, shells({0.35, 0.5, 0.65}, 0.015, 0.7),
                                 fit_camera(slice, false, 20, 30, Exact::size, Exact::size));
  const Exact exact(scene);
  RenderOptions o = flat(1);
  o.reference = true;
  EXPECT_GT(exact.db(o), 45);
}

TEST(Preintegrate, NeitherThreadsNorTilesNorSkipsChangeABit) {
  // A ball in an empty domain, partly outside the picture, with a shell in its rise and an opaque core.
  const Slice slice = make_slice({64, 64, 64}, [](double x, double y, double z) {
    return 1 / (1 + std::exp(2 * (std::hypot(x - 31, y - 31, z - 31) - 14)));
  });
  TransferFunction f = peak(0.2, 0.02, 0.3);
  f.opacities.insert(f.opacities.end(), {{0.6, 0}, {0.62, 0.95}});
  const std::vector<std::pair<GradientMethod, double>> ways{{GradientMethod::analytic, 0.5},
                                                            {GradientMethod::fourth_order, 0.5},
                                                            {GradientMethod::central, 1.0},
                                                            {GradientMethod::fourth_order, 0.25},
                                                            {GradientMethod::central, 1.7}};
  for (const bool perspective : {false, true})
    for (const auto& [gradient, step] : test::some(ways, 3)) {
      Scene scene = make_scene(slice, f, fit_camera(slice, perspective, 20, 30, 80, 80));
      if (!perspective) scene.camera.ortho_height *= 0.5;
      RenderOptions o;
      o.preintegrate = Preintegrate::on;
      o.gradient = gradient, o.sheet_step = step;
      o.shading = step != 1;
      if (step == 0.25) // as fine pictures are
        o.raise = RaiseFilter{.taps = 8, .density = 1.99, .from = 1.35, .from_general = 1.2, .depth = 2};
      o.tile_size = 16;
      ImageStorage all(80, 80, true, true, true);
      const RenderStats skipped = draw(scene, o, all, 1);
      EXPECT_GT(skipped.drawn.points_occluded, 0u);
      EXPECT_GT(skipped.drawn.sheets_skipped, 0u);
      EXPECT_GT(skipped.drawn.bricks_invisible + skipped.drawn.points_invisible, 0u);
      for (const uint32_t bits : {1u, 4u, 8u, 64u, 79u}) {
        o.disable_skips = bits;
        ImageStorage other(80, 80, true, true, true);
        draw(scene, o, other);
        EXPECT_TRUE(same_bits(all, other)) << "skips " << bits << " step " << step << ' ' << perspective;
      }
      o.disable_skips = 0;
      for (const auto& [tile, threads] : {std::pair{64, 3}, {23, 2}, {0, 4}}) {
        o.tile_size = tile;
        ImageStorage other(80, 80, true, true, true);
        draw(scene, o, other, threads);
        EXPECT_TRUE(same_bits(all, other)) << "tile " << tile << " step " << step << ' ' << perspective;
      }
    }
}

TEST(Preintegrate, IsChosenWhereTheFunctionIsNarrowerThanAStep) {
  const Slice slice = make_slice({30, 24, 28}, marschner_lobb(28, 3));
  const Camera camera = fit_camera(slice, false, 20, 30, 48, 48);
  const auto drawn = [&](const TransferFunction& f, Quality quality, Preintegrate choice, ImageStorage& out,
                         RenderMode mode = RenderMode::composite) {
    RenderOptions o;
    o.quality = quality, o.preintegrate = choice, o.mode = mode, o.iso_value = 0.5;
    if (mode == RenderMode::xray) o.shading = false;
    return draw(make_scene(slice, f, camera), o, out).drawn.preintegrated;
  };
  ImageStorage a(48, 48, true, true, true), b(48, 48, true, true, true);
  // Smooth functions are drawn as if there were no such thing.
  for (const TransferFunction& f : {ramp_function(0.3, 1, 0.35), ramp_function(0, 1, 0.9)})
    for (const Quality q : {Quality::draft, Quality::normal, Quality::fine, Quality::best}) {
      EXPECT_FALSE(drawn(f, q, Preintegrate::automatic, a));
      EXPECT_FALSE(drawn(f, q, Preintegrate::off, b));
      EXPECT_TRUE(same_bits(a, b));
    }
  for (const Quality q : {Quality::draft, Quality::normal, Quality::fine}) {
    EXPECT_TRUE(drawn(peak(0.5, 0.01, 0.9), q, Preintegrate::automatic, a));
    EXPECT_TRUE(drawn(peak(0.5, 0.01, 0.9), q, Preintegrate::on, b));
    EXPECT_TRUE(same_bits(a, b));
    EXPECT_FALSE(drawn(peak(0.5, 0.01, 0.9), q, Preintegrate::off, b));
    EXPECT_FALSE(same_bits(a, b));
  }
  // The same peak is wide for finer sheets.
  EXPECT_TRUE(drawn(peak(0.5, 0.2, 0.9), Quality::draft, Preintegrate::automatic, a));
  EXPECT_FALSE(drawn(peak(0.5, 0.2, 0.9), Quality::best, Preintegrate::automatic, a));
  // Other modes do not classify segments.
  for (const RenderMode m : {RenderMode::isosurface, RenderMode::xray, RenderMode::maximum}) {
    EXPECT_FALSE(drawn(peak(0.5, 0.01, 0.9), Quality::normal, Preintegrate::on, a, m));
    EXPECT_FALSE(drawn(peak(0.5, 0.01, 0.9), Quality::normal, Preintegrate::off, b, m));
    EXPECT_TRUE(same_bits(a, b));
  }
}

TEST(Preintegrate, NarrownessIsThatOfTheShape) {
  const auto of = [](const TransferFunction& f, double change) {
    return narrowness(f, make_class_table(f, 0, 1, 0, 1, 2001), change, 0.5);
  };
  TransferFunction grey = ramp_function(0, 1, 0.01); // extinction nearly linear
  grey.colors = {{0, {1, 1, 1}}};
  EXPECT_NEAR(of(grey, 0.2), 0.2 / 8, 2e-3);
  grey.opacities = {{0, 0}, {0.5, 0}, {0.5, 0.01}, {1, 0.01}};
  EXPECT_NEAR(of(grey, 0.2), 0.5, 5e-3);
  grey.opacities = peak(0.5, 0.1, 0.01).opacities; // the mean over a change of its half-width is 3/4
  EXPECT_NEAR(of(grey, 0.1), 0.25, 5e-3);
  EXPECT_GT(of(grey, 0.9), 0.85);
  grey.opacities = {{0, 0.2}};
  EXPECT_EQ(of(grey, 0.5), 0);
  // Between two entries, alone or beside something wide.
  grey.opacities = peak(0.50025, 1e-4, 0.01).opacities;
  EXPECT_GT(of(grey, 0.1), 0.95);
  grey.opacities.insert(grey.opacities.begin(), {{0, 0}, {0.2, 0.005}, {0.4, 0}});
  EXPECT_GT(of(grey, 0.1), 0.9);
}

// A tent far narrower than an entry of the table is drawn with its share of what a wider one shows, by
// default, too.
TEST(Preintegrate, PeaksBetweenEntriesAreDrawn) {
  const Slice slice = make_slice({32, 32, 32}, [](double x, double y, double z) {
    return 1 - std::hypot(x - 15.5, y - 15.5, z - 15.5) / 16;
  });
  const auto opacity = [&](double value, double half_width, double most, Preintegrate choice) {
    const TransferFunction f = peak(value, half_width, most);
    const Scene scene = make_scene(slice, f, fit_camera(slice, false, 0, 0, 41, 41));
    ImageStorage out(41, 41, false, false, false);
    RenderOptions o = flat(1);
    o.quality = Quality::normal, o.preintegrate = choice;
    (void)draw(scene, o, out);
    double sum = 0;
    for (size_t p = 3; p < out.rgba.size(); p += 4) sum += out.rgba[p];
    return sum;
  };
  for (const double value : {0.5001, 0.50025, 0.5004}) {
    const double on = opacity(value, 1e-4, 0.99, Preintegrate::on);
    EXPECT_GT(on, 0) << value;
    EXPECT_EQ(opacity(value, 1e-4, 0.99, Preintegrate::automatic), on) << value;
    EXPECT_NEAR(on / opacity(value, 1e-3, 0.99, Preintegrate::on), 0.1, 0.015) << value;
  }
}

TEST(Preintegrate, FieldsSayHowFastTheyChange) {
  const Slice slice =
      make_slice({24, 24, 24}, [](double x, double y, double z) { return 0.05 * (x + y) + 0.07 * z; });
  TestContext context;
  const double change = change_per_unit(slice, make_points(slice, context.get()));
  const double unit = length(slice.lattice_to_slice.vector({1, 0, 0}));
  EXPECT_NEAR(change, unit * std::hypot(0.05, 0.05, 0.07), 0.2 * unit * 0.1); // mirrors at the ends, ripple
}

TEST(Preintegrate, ValueAndDepthAreThoseOfTheShell) {
  const Slice slice = make_slice({32, 32, 32}, [](double x, double y, double z) {
    return 1 - std::hypot(x - 15.5, y - 15.5, z - 15.5) / 16;
  });
  TransferFunction f = peak(0, 1, 0);
  f.opacities = {{0.596, 0}, {0.596, 1}, {0.604, 1}, {0.604, 0}};
  const Scene scene = make_scene(slice, f, fit_camera(slice, false, 0, 0, 41, 41));
  ImageStorage out(41, 41, true, true, true);
  RenderOptions o = flat(1);
  draw(scene, o, out);
  EXPECT_GT(out.image.rgba.at(20, 20)[3], 0.99f);
  EXPECT_NEAR(*out.image.value.at(20, 20), 0.6, 0.004);
  // The shell's nearest point, to the half of a segment that holds it.
  ImageStorage fine(41, 41, true, true, true);
  draw(scene, flat(0.125), fine);
  EXPECT_NEAR(*out.image.depth.at(20, 20), *fine.image.depth.at(20, 20), 0.5);
}

TEST(Preintegrate, DeepPicturesFlattenToTheFlatOne) {
  const Slice slice = make_slice({24, 20, 22}, marschner_lobb(24, 2));
  const Scene scene =
      make_scene(slice, shells({0.4, 0.6}, 0.01, 0.5), fit_camera(slice, false, 20, 30, 40, 32));
  ImageStorage out(40, 32, true);
  DeepImage deep;
  out.image.deep = &deep;
  TestContext context(2);
  RenderOptions o;
  EXPECT_TRUE(render(scene, o, context.get(), out.image).drawn.preintegrated);
  size_t seen = 0;
  for (size_t p = 0; p < size_t{40} * 32; ++p) {
    std::array<double, 4> sum{};
    for (size_t n = deep.first[p]; n < deep.first[p + 1]; ++n) {
      const float* s = deep.samples.data() + n * DeepImage::components;
      const double open = 1 - sum[3];
      for (size_t c = 0; c < 3; ++c) sum[c] += open * s[3 + c];
      sum[3] += open * s[2];
    }
    for (size_t c = 0; c < 4; ++c) ASSERT_NEAR(sum[c], out.rgba[4 * p + c], 1e-5) << p;
    seen += sum[3] > 0;
  }
  EXPECT_GT(seen, 200u);
}

} // namespace
} // namespace bccsplat
