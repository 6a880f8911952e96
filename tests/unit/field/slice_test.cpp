// SPDX-License-Identifier: Apache-2.0
// The field as volume and time slices give it: constants, waves, one site, gradients, ends, means, holes and
// what lies outside, with every kernel; the same bits whatever caches and threads.
#include "field/slice.h"

#include <gtest/gtest.h>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"
#include "tests/unit/field/evaluated.h"

namespace bccsplat {
namespace {

using test::evaluate_values;
using test::large_cache;
using test::PlaneWaves;
using test::random_points;
using test::sample_field;
using test::snr_db;
using test::TestContext;

// Points of a time slice (index units) in the slice's lattice units.
std::vector<Vec3> slice_points(const Lattice4& lattice, const std::vector<Vec4>& points) {
  const Vec3 unit = lattice.lattice_unit();
  std::vector<Vec3> result;
  for (const Vec4& p : points) result.push_back({p[0] / unit[0], p[1] / unit[1], p[2] / unit[2]});
  return result;
}

class EveryKernel : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Slice, EveryKernel,
                         testing::Values("fast", "default", "fine", "gauss09", "paper", "radial18+b4"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), '+', '_');
                           return name;
                         });

TEST_P(EveryKernel, ConstantStaysConstantUpToTheEnds) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {19, 14, 23, 9});
  const auto samples = sample_field(lattice, [](const Vec4&) { return 7.0; });
  const Coefficients c(samples, 0, make_kernel(GetParam()), 0, large_cache);
  const auto points = random_points(lattice, 2000, 1);
  const double tolerance =
      GetParam() == std::string("default") || GetParam() == std::string("fine") ? 0.003 : 0.02; // DC ripple
  for (const float v : evaluate_values(c, points, context.get())) ASSERT_NEAR(v, 7.0, 7.0 * tolerance);
}

TEST_P(EveryKernel, SliceAgreesWithTheVolume) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {20, 17, 18, 12});
  const auto samples = sample_field(lattice, PlaneWaves(8, 0.6, 3));
  const Coefficients c(samples, 0, make_kernel(GetParam()), 0, large_cache);
  for (const double frame : {0.0, 0.3, 5.0, 7.77, 11.0}) {
    auto points = random_points(lattice, 300, 5);
    for (Vec4& p : points) p[3] = frame;
    std::vector<float> volume(points.size()), slice_values(points.size());
    std::vector<std::array<float, 4>> volume_gradient(points.size());
    std::vector<std::array<float, 3>> slice_gradient(points.size());
    evaluate4(c, points, volume, volume_gradient, context.get());
    const Slice slice = time_slice(c, frame, {0, 0}, {}, context.get());
    const auto at = slice_points(lattice, points);
    evaluate(slice, at, slice_values, slice_gradient);
    const Vec3 unit = lattice.lattice_unit();
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_NEAR(volume[i], slice_values[i], 2e-5) << "frame " << frame;
      Vec3 reference_gradient;
      ASSERT_NEAR(evaluate_reference(slice, at[i], &reference_gradient), slice_values[i], 2e-5);
      for (size_t a = 0; a < 3; ++a) {
        ASSERT_NEAR(slice_gradient[i][a], reference_gradient[a], 1e-4);
        ASSERT_NEAR(volume_gradient[i][a], slice_gradient[i][a] / unit[a], 1e-4);
      }
      ASSERT_GE(slice_values[i], slice.bounds[0]);
      ASSERT_LE(slice_values[i], slice.bounds[1]);
    }
  }
}

TEST_P(EveryKernel, GradientIsTheDerivative) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {14, 15, 16, 10});
  const auto samples = sample_field(lattice, PlaneWaves(6, 0.5, 9));
  const Coefficients c(samples, 0, make_kernel(GetParam()), 0, large_cache);
  const auto points = random_points(lattice, 100, 11, 0.1);
  // The truncated Gaussians jump by 7e-4 of their peak at the cut, and a hat has corners: a few points
  // straddle them.
  for (const size_t misses : test::gradient_misses(c, points, 0.01, context.get())) EXPECT_LE(misses, 40u);
}

struct Accuracy {
  const char* kernel;
  std::array<double, 3> snr; // dB at rho 0.5, 0.7, 0.9, less 2 dB for the few waves drawn
};

TEST(Slice, PlaneWavesReachTheKernelsAccuracy) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {40, 40, 40, 40});
  for (const Accuracy& asked : {Accuracy{"default", {49, 31, 16.5}}, Accuracy{"fine", {58, 39, 20}}}) {
    size_t i = 0;
    for (const double rho : {0.5, 0.7, 0.9}) {
      const PlaneWaves waves(12, rho, 17);
      const auto samples = sample_field(lattice, waves);
      const Coefficients c(samples, 0, make_kernel(asked.kernel), 0, large_cache);
      const auto points = random_points(lattice, 4000, 19, 12);
      const double snr = snr_db(evaluate_values(c, points, context.get()), points, waves);
      RecordProperty(std::string(asked.kernel) + std::to_string(i), std::to_string(snr));
      EXPECT_GE(snr, asked.snr[i++]) << asked.kernel << " at rho " << rho;
    }
  }
}

TEST(Slice, OneSiteIsTheKernel) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {24, 24, 24, 20});
  Kernel kernel = make_kernel("default");
  kernel.prefilter4.clear();
  const int32_t layer = 9;
  const Int3 site{7, 8, 6};
  const Vec3 at = lattice.site_position(lattice.coset(layer), site);
  const double frame = lattice.layer_frame(layer);
  const auto samples = sample_field(lattice, [&](const Vec4& p) {
    return std::fabs(p[0] - at[0]) + std::fabs(p[1] - at[1]) + std::fabs(p[2] - at[2]) +
                       std::fabs(p[3] - frame) <
                   1e-6
               ? 3
               : 0;
  });
  const Coefficients c(samples, 0, kernel, 0, large_cache);
  const Vec3 unit = lattice.lattice_unit();
  const double time_unit = lattice.time_step / lattice.layer_distance();
  auto points = random_points(lattice, 4000, 23);
  for (auto& p : points) {
    for (size_t a = 0; a < 3; ++a) p[a] = at[a] + (p[a] - 11.5) / 5;
    p[3] = frame + (p[3] - 9.5) / 4;
  }
  const auto values = evaluate_values(c, points, context.get());
  for (size_t i = 0; i < points.size(); ++i) {
    double r2 = 0;
    for (size_t a = 0; a < 3; ++a) r2 += std::pow((points[i][a] - at[a]) / unit[a], 2);
    ASSERT_NEAR(values[i], 3 * kernel.space.value(r2) * kernel.time.value((points[i][3] - frame) / time_unit),
                1e-6);
  }
}

TEST(Slice, Linear) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {18, 18, 18, 10});
  const PlaneWaves f(5, 0.8, 29), g(5, 0.8, 31);
  const auto sf = sample_field(lattice, f), sg = sample_field(lattice, g);
  const auto sum = sample_field(lattice, [&](const Vec4& p) { return 2 * f(p) - 3 * g(p); });
  const auto points = random_points(lattice, 500, 37);
  const auto values = [&](const MemorySamples& s) {
    return evaluate_values(Coefficients(s, 0, make_kernel("default"), 0, large_cache), points, context.get());
  };
  const auto a = values(sf), b = values(sg), both = values(sum);
  for (size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(both[i], 2 * a[i] - 3 * b[i], 1e-4);
}

TEST(Slice, AirIsOnlyAnOffset) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {18, 18, 18, 10});
  const PlaneWaves f(5, 0.6, 41);
  const auto plain = sample_field(lattice, f), lifted = sample_field(
                                                   lattice, [&](const Vec4&p) { return f(p) + 5; }, 5);
  const auto points = random_points(lattice, 300, 43);
  const auto a = evaluate_values({plain, 0, make_kernel("fast"), 0, large_cache}, points, context.get());
  const auto b = evaluate_values({lifted, 0, make_kernel("fast"), 0, large_cache}, points, context.get());
  for (size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(a[i] + 5, b[i], 1e-5);
}

TEST(Slice, EndsMirrorTheField) {
  // A field that is even about both ends of every axis is reconstructed at the ends as well as inside.
  TestContext context;
  const std::array<uint32_t, 4> dims{25, 31, 28, 15}; // 14 frames = 20 layers less a quarter: see time_scale
  const double time_scale = 14 / (20 / std::numbers::sqrt2);
  const auto lattice = Lattice4::fit(LatticeKind::d4star, dims, {1, 1, 1, time_scale});
  const auto f = [&](const Vec4& p) {
    double v = 1;
    for (size_t a = 0; a < 4; ++a)
      v *= std::cos(std::numbers::pi * (static_cast<double>(a) + 2) * p[a] / (dims[a] - 1.0));
    return v;
  };
  const auto samples = sample_field(lattice, f);
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  auto points = random_points(lattice, 3000, 47);
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t a = i % 4;
    points[i][a] = (i / 4) % 2 ? dims[a] - 1.0 : 0; // on a face of the domain
  }
  const auto values = evaluate_values(c, points, context.get());
  EXPECT_GE(snr_db(values, points, f), 45);
}

TEST(Slice, CacheAndThreadsDoNotChangeABit) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {40, 20, 36, 14});
  const auto samples = sample_field(lattice, PlaneWaves(6, 0.8, 53));
  const auto points = random_points(lattice, 1000, 59);
  TestContext one(1), four(4);
  const auto a = evaluate_values({samples, 0, make_kernel("fine"), 0, large_cache}, points, one.get());
  const auto b = evaluate_values({samples, 0, make_kernel("fine"), 0, 1 << 21}, points, four.get());
  EXPECT_EQ(a, b);
  Coefficients warm(samples, 0, make_kernel("fine"), 0, large_cache);
  std::vector<float> reversed(points.size());
  for (size_t i = points.size(); i-- > 0;) reversed[i] = evaluate_values(warm, {points[i]}, four.get())[0];
  EXPECT_EQ(a, reversed);
}

TEST(Slice, MeanIsTheMeanOfInstants) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {16, 16, 16, 12});
  const auto samples = sample_field(lattice, PlaneWaves(6, 0.6, 61));
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  const Slice mean = time_slice(c, 6.2, {-2.5, 1.0}, {}, context.get());
  const auto points = random_points(lattice, 50, 67);
  const auto at = slice_points(lattice, points);
  std::vector<double> sum(points.size());
  constexpr int count = 256;
  std::vector<float> v(points.size());
  for (int k = 0; k < count; ++k) {
    evaluate(time_slice(c, 6.2 - 2.5 + 3.5 * (k + 0.5) / count, {0, 0}, {}, context.get()), at, v, {});
    for (size_t i = 0; i < v.size(); ++i) sum[i] += v[i] / double{count};
  }
  evaluate(mean, at, v, {});
  for (size_t i = 0; i < v.size(); ++i) EXPECT_NEAR(v[i], sum[i], 1e-4);
}

TEST(Slice, StaticVolumeIgnoresTime) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {33, 33, 33, 1});
  ASSERT_EQ(lattice.kind, LatticeKind::bcc);
  const PlaneWaves f(12, 0.5, 71, 3);
  const auto samples = sample_field(lattice, f);
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  auto points = random_points(lattice, 2000, 73, 6);
  EXPECT_GE(snr_db(evaluate_values(c, points, context.get()), points, f), 50);
  const Slice slice = time_slice(c, 123, {0, 0}, {}, context.get());
  std::vector<float> v(points.size());
  EXPECT_EQ(evaluate(slice, slice_points(lattice, points), v, {}).outside, 0u);
  EXPECT_GE(snr_db(v, points, f), 50);
}

TEST(Slice, OutsideIsNaNAndCounted) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {8, 8, 8, 4});
  const auto samples = sample_field(lattice, [](const Vec4&) { return 1.0; });
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  const std::vector<Vec4> points{
      {-0.1, 1, 1, 1}, {1, 7.01, 1, 1}, {1, 1, 1, 3.01}, {1, 1, 1, std::nan("")}, {0, 7, 7, 3}};
  std::vector<float> v(points.size());
  EXPECT_EQ(evaluate4(c, points, v, {}, context.get()).outside, 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_TRUE(std::isnan(v[i]));
  EXPECT_NEAR(v[4], 1, 0.01);
  EXPECT_THROW((void)time_slice(c, 3.5, {0, 0}, {}, context.get()), Error);
  EXPECT_THROW((void)time_slice(c, 1, {1, 0}, {}, context.get()), Error);
}

TEST(Slice, HolesHaveNoValue) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::bcc, {12, 12, 12, 1});
  std::vector<BrickLayer> layers;
  for (int coset = 0; coset < 2; ++coset) {
    BrickLayer layer(lattice.space, coset);
    auto brick = std::make_shared<Brick>();
    brick->hole = std::make_unique<BrickMask>();
    brick->value[0] = 1;
    brick->kept[0] = 1;
    if (coset == 0) (*brick->hole)[4 * brick_edge + 4] = 1 << 4; // site (4, 4, 4)
    layer.set(0, std::move(brick));
    layers.push_back(std::move(layer));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  const MemorySamples samples(lattice, {0}, std::move(channels));
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  const Vec3 at = lattice.site_position(0, {4, 4, 4});
  const std::vector<Vec4> points{
      {at[0], at[1], at[2], 0}, {at[0] + 0.2, at[1], at[2], 0}, {at[0] + 1, at[1], at[2], 0}};
  std::vector<float> v(3);
  EXPECT_EQ(evaluate4(c, points, v, {}, context.get()).holes, 2u);
  EXPECT_TRUE(std::isnan(v[0]) && std::isnan(v[1]) && !std::isnan(v[2]));
  const Slice slice = time_slice(c, 0, {0, 0}, {}, context.get());
  EXPECT_TRUE(slice.has_holes);
  EXPECT_EQ(evaluate(slice, slice_points(lattice, points), v, {}).holes, 2u);
}

TEST(Slice, BudgetIsKept) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {40, 40, 40, 10});
  const auto samples = sample_field(lattice, PlaneWaves(4, 0.5, 79));
  TestContext small(2, 100'000);
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  try {
    (void)time_slice(c, 4, {0, 0}, {}, small.get());
    FAIL() << "a budget smaller than one layer was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::memory_budget);
  }
  EXPECT_LE(small.memory.peak(), 100'000u);
}

} // namespace
} // namespace bccsplat
