// SPDX-License-Identifier: Apache-2.0
// The Cartesian twin: kernels on CC, and slices and evaluation of 4D CC series.
#include "kernel/cc_kernel.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "kernel/radial.h"
#include "slice/plane_slice.h"
#include "slice/time_slice.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"
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

double cubic_site_sum(const RadialKernel& phi, const Vec3& p) {
  double sum = 0;
  for (int z = -4; z <= 4; ++z)
    for (int y = -4; y <= 4; ++y)
      for (int x = -4; x <= 4; ++x) {
        const Vec3 v = p - Vec3{double(x), double(y), double(z)};
        sum += phi.value(dot(v, v));
      }
  return sum;
}

TEST(CcKernel, SumsToOneInTheMeanWithASmallRipple) {
  // The bound that slices give for their values allows 2 %.
  for (const auto& [name, ripple] :
       {std::pair{"radial16+b3", 0.02}, {"radial18+b3", 0.01}, {"radial20+b3", 0.004}, {"exact", 0.01}}) {
    const CcKernel cc = make_cc_kernel(name);
    EXPECT_NEAR(radial_integral(cc.kernel.space), 1, 1e-9);
    for (int i = 0; i < 125; ++i) {
      const Vec3 p{0.125 * (i % 5), 0.125 * (i / 5 % 5), 0.125 * (i / 25)};
      EXPECT_NEAR(cubic_site_sum(cc.kernel.space, p), 1, ripple) << name;
    }
  }
}

TEST(CcKernel, PaperLatticeSumIsTheSumOfTheWeights) {
  const Kernel paper = make_cc_kernel("paper").kernel;
  EXPECT_TRUE(paper.normalised);
  EXPECT_EQ(paper.time.shape, TemporalKernel::Shape::bspline);
  EXPECT_EQ(paper.time.order, 2); // linear in time
  for (int i = 0; i < 64; ++i) {
    const Vec3 p{0.2 * (i % 4), 0.17 * (i / 4 % 4), 0.13 * (i / 16)};
    EXPECT_NEAR(cc_lattice_sum(paper, p[0], p[1], p[2]), cubic_site_sum(paper.space, p),
                2.5e-3); // cut at 2 T
  }
  EXPECT_EQ(cc_lattice_sum(make_cc_kernel("default").kernel, 0.3, 0.4, 0.1), 1);
}

TEST(CcKernel, WiderKernelsAreRefused) {
  for (const char* name : {"fine", "gauss09", "radial24+b2"}) {
    try {
      (void)make_cc_kernel(name);
      ADD_FAILURE() << name;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::unsupported);
    }
  }
}

class CcVolume : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cc, CcVolume, testing::Values("fast", "default", "exact", "paper", "radial20+b4"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), '+', '_');
                           return name;
                         });

TEST_P(CcVolume, ConstantStaysConstantUpToTheEnds) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {19, 14, 23, 9});
  ASSERT_EQ(lattice.layers(), 9);
  const auto samples = sample_field(lattice, [](const Vec4&) { return 7.0; });
  const Coefficients c(samples, 0, make_kernel(GetParam()), 0, large_cache);
  for (const float v : evaluate_values(c, random_points(lattice, 2000, 1), context.get()))
    ASSERT_NEAR(v, 7, 7 * 0.02);
}

TEST_P(CcVolume, IsLinearInTheSamples) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {12, 13, 14, 8});
  const PlaneWaves f(5, 0.6, 3), g(5, 0.6, 4);
  const auto a = sample_field(lattice, f), b = sample_field(lattice, g),
             both = sample_field(lattice, [&](const Vec4&p) { return 2 * f(p) - 0.5 * g(p); });
  const auto points = random_points(lattice, 500, 5);
  const Kernel kernel = make_kernel(GetParam());
  const auto va = evaluate_values({a, 0, kernel, 0, large_cache}, points, context.get());
  const auto vb = evaluate_values({b, 0, kernel, 0, large_cache}, points, context.get());
  const auto v = evaluate_values({both, 0, kernel, 0, large_cache}, points, context.get());
  for (size_t i = 0; i < v.size(); ++i) ASSERT_NEAR(v[i], 2 * va[i] - 0.5f * vb[i], 2e-5);
}

TEST_P(CcVolume, SliceAgreesWithTheVolume) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {20, 17, 35, 12});
  const auto samples = sample_field(lattice, PlaneWaves(8, 0.6, 3));
  const Coefficients c(samples, 0, make_kernel(GetParam()), 0, large_cache);
  for (const double frame : {0.0, 0.3, 5.0, 7.77, 11.0}) {
    auto points = random_points(lattice, 300, 5);
    std::vector<Vec3> at;
    for (Vec4& p : points) p[3] = frame, at.push_back({p[0], p[1], p[2]});
    std::vector<float> volume(points.size()), slice_values(points.size());
    std::vector<std::array<float, 4>> volume_gradient(points.size());
    std::vector<std::array<float, 3>> slice_gradient(points.size());
    evaluate4(c, points, volume, volume_gradient, context.get());
    const Slice slice = time_slice(c, frame, {0, 0}, {}, context.get());
    ASSERT_FALSE(slice.lattice.bcc);
    evaluate(slice, at, slice_values, slice_gradient);
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_NEAR(volume[i], slice_values[i], 2e-5);
      Vec3 gradient;
      ASSERT_NEAR(evaluate_reference(slice, at[i], &gradient), slice_values[i], 2e-5);
      for (size_t a = 0; a < 3; ++a) {
        ASSERT_NEAR(slice_gradient[i][a], gradient[a], 1e-4);
        ASSERT_NEAR(volume_gradient[i][a], gradient[a], 1e-4);
      }
      ASSERT_GE(slice_values[i], slice.bounds[0]);
      ASSERT_LE(slice_values[i], slice.bounds[1]);
    }
    // The dense way must agree, too.
    std::vector<float> grid(20 * 17 * 35);
    sample_grid(slice, {{0, 0, 0}, {1, 1, 1}, {20, 17, 35}}, grid.data(), context.get());
    for (size_t i = 0; i < grid.size(); i += 97) {
      const Vec3 p{double(i % 20), double(i / 20 % 17), double(i / 340)};
      ASSERT_NEAR(grid[i], evaluate_reference(slice, p, nullptr), 2e-5);
    }
  }
}

TEST_P(CcVolume, GradientIsTheDerivative) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {14, 15, 16, 10});
  const auto samples = sample_field(lattice, PlaneWaves(6, 0.5, 9));
  const Coefficients c(samples, 0, make_kernel(GetParam()), 0, large_cache);
  const auto points = random_points(lattice, 100, 11, 0.1);
  // The truncated Gaussians jump by 7e-4 of their peak at the cut, and a hat has corners: a few points
  // straddle them.
  for (const size_t misses : test::gradient_misses(c, points, 0.01, context.get())) EXPECT_LE(misses, 30u);
}

TEST(CcVolume, PlaneWavesReachTheKernelsAccuracy) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {40, 40, 40, 40});
  struct Asked {
    const char* kernel;
    std::array<double, 3> snr; // dB at rho 0.5, 0.7, 0.9
  };
  for (const Asked& asked : {Asked{"default", {43, 31.5, 19}}, Asked{"radial20+b4", {53, 37, 21}},
                             Asked{"exact", {37, 28.5, 19.5}}}) {
    size_t i = 0;
    for (const double rho : {0.5, 0.7, 0.9}) {
      const PlaneWaves f(24, rho, 17);
      const auto samples = sample_field(lattice, f);
      const auto points = random_points(lattice, 4000, 19, 10);
      const double snr = snr_db(
          evaluate_values({samples, 0, make_kernel(asked.kernel), 0, large_cache}, points, context.get()),
          points, f);
      EXPECT_GE(snr, asked.snr[i++]) << asked.kernel << " at rho " << rho;
    }
  }
}

TEST(CcVolume, SamplesComeBackAtTheSites) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {24, 24, 24, 16});
  const PlaneWaves f(12, 0.6, 23);
  const auto samples = sample_field(lattice, f);
  std::vector<Vec4> sites;
  for (int i = 0; i < 2000; ++i)
    sites.push_back(
        {double(6 + i % 12), double(6 + i / 12 % 12), double(6 + i / 144 % 12), double(5 + i % 6)});
  // This is far better than between the sites, where the kernel itself limits.
  EXPECT_GE(
      snr_db(evaluate_values({samples, 0, make_kernel("radial20+b4"), 0, large_cache}, sites, context.get()),
             sites, f),
      48);
}

// Returns samples of full swing from site to site, with all frequencies alike.
MemorySamples white_noise(const Lattice4& lattice, double codes) {
  std::mt19937 random(7);
  return sample_field(lattice, [&](const Vec4&) {
    return std::floor(std::uniform_real_distribution<double>(0, codes)(random));
  });
}

TEST(ExactKernel, SamplesComeBackToRounding) {
  TestContext context;
  for (const auto& dims :
       {std::array<uint32_t, 4>{23, 37, 18, 13}, {40, 19, 21, 1}, {1, 1, 33, 2}, {2, 3, 5, 30}}) {
    const auto lattice = Lattice4::fit(LatticeKind::cc, dims);
    const auto samples = white_noise(lattice, 256);
    const Coefficients exact(samples, 0, make_kernel("exact"), 0, large_cache);
    // Axes of one sample have a second site, beyond the domain.
    const Int3 sites = lattice.space.dims(0);
    Int3 n;
    for (size_t a = 0; a < 3; ++a) n[a] = dims[a];
    std::vector<float> grid(static_cast<size_t>(n[0]) * n[1] * n[2]);
    double worst = 0, most = 0;
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const std::vector<float> expected = layer_to_dense(samples.read_layer(0, m, {}, context.get()));
      const Slice slice = time_slice(exact, m, {0, 0}, {}, context.get());
      sample_grid(slice, {{0, 0, 0}, {1, 1, 1}, n}, grid.data(), context.get());
      for (int i = 0; i < n[0] * n[1] * n[2]; ++i) {
        const int x = i % n[0], y = i / n[0] % n[1], z = i / (n[0] * n[1]);
        const float got = grid[i];
        const float site = expected[(z * sites[1] + y) * sites[0] + x];
        worst = larger(worst, std::fabs(static_cast<double>(got) - site));
        ASSERT_GE(got, slice.bounds[0]);
        ASSERT_LE(got, slice.bounds[1]);
      }
      for (const double bound : slice.bounds) most = larger(most, std::fabs(bound));
    }
    EXPECT_LT(worst, 2e-3) << dims[0]; // coefficients of up to 5000
    EXPECT_LT(most, 256 * make_cc_kernel("exact").kernel.prefilter_gain * 1.02);
  }
}

TEST(ExactKernel, GoesThroughSamplesThatAreSites) {
  using enum LatticeKind;
  const Kernel exact = make_kernel("exact");
  EXPECT_TRUE(goes_through_samples(Lattice4::fit(cc, {9, 8, 7, 5}), exact));
  EXPECT_TRUE(goes_through_samples(Lattice4::fit(cc, {9, 8, 7, 1}), exact));
  EXPECT_TRUE(goes_through_samples(Lattice4::fit(cc, {9, 8, 7, 5}, {1, 1, 1, 1}, 2, {2, 0, 0}), exact));
  EXPECT_TRUE(goes_through_samples(Lattice4::fit(cc, {9, 1, 7, 5}, {1, 2, 1, 1}), exact)) << "of one sample";
  EXPECT_FALSE(goes_through_samples(Lattice4::fit(cc, {9, 8, 7, 5}), make_kernel("default")));
  EXPECT_FALSE(goes_through_samples(Lattice4::fit(d4star, {9, 8, 7, 5}), exact));
  for (size_t a = 0; a < 4; ++a) {
    LatticeScales scales{1, 1, 1, 1};
    scales[a] = 2;
    EXPECT_FALSE(goes_through_samples(Lattice4::fit(cc, {9, 9, 9, 9}, scales), exact)) << a;
  }
}

TEST(ExactKernel, NeighboursInSpaceFallByOneFactor) {
  const RadialKernel phi = make_cc_kernel("exact").kernel.space;
  const double fall = phi.value(1) / phi.value(0);
  EXPECT_NEAR(phi.value(2), fall * phi.value(1), 1e-7);
  EXPECT_NEAR(phi.value(3), fall * phi.value(2), 1e-7);
  EXPECT_EQ(phi.value(4), 0);
}

TEST(ExactKernel, CachesAndRegionsChangeNothing) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {20, 20, 150, 24});
  const auto samples = white_noise(lattice, 256);
  const Kernel kernel = make_kernel("exact");
  const Coefficients roomy(samples, 0, kernel, 0, large_cache);
  for (const uint64_t cache : {uint64_t{0}, uint64_t{3} << 20}) {
    const Coefficients tight(samples, 0, kernel, 0, cache);
    for (int32_t m = 8; m < 12; ++m)
      ASSERT_EQ(layer_to_dense(*tight.layer(m, context.get())),
                layer_to_dense(*roomy.layer(m, context.get())));
  }
  const Coefficients part(samples, 0, kernel, 0, large_cache, {{0, 0, 3}, {2, 2, 8}});
  const auto some = part.layer(9, context.get()), all = roomy.layer(9, context.get());
  for (int z = 4; z < 7; ++z) // beyond the reach of the region's faces
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x) EXPECT_EQ(some->brick(x, y, z)->value, all->brick(x, y, z)->value);
}

TEST(ExactKernel, HolesStayAndAirIsPruned) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {60, 20, 20, 1});
  std::vector<float> dense(60 * 20 * 20, 0.0f);
  dense[10 * 20 * 60 + 10 * 60 + 8] = 100;
  BrickLayer layer = test::layer_from_dense(lattice.space, 0, dense);
  auto hole = std::make_shared<Brick>();
  hole->hole = std::make_unique<BrickMask>();
  (*hole->hole)[5] = 1;
  layer.set(layer.slot(3, 0, 0), std::move(hole));
  const MemorySamples samples(lattice, {0}, {{std::move(layer)}});
  const Coefficients c(samples, 0, make_kernel("exact"), 0.01f, large_cache);
  const auto made = c.layer(0, context.get());
  EXPECT_TRUE(made->brick(3, 0, 0)->is_hole(5 * 16));
  EXPECT_FALSE(made->brick(2, 0, 0)); // all below 0.01
  EXPECT_GT(made->brick(0, 0, 0)->count(), 100);
}

TEST(CcVolume, StaticVolumesAreThreeDimensional) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {33, 33, 33, 1});
  ASSERT_EQ(lattice.layers(), 1);
  const PlaneWaves f(12, 0.5, 71, 3);
  const auto samples = sample_field(lattice, f);
  const auto points = random_points(lattice, 2000, 73, 6);
  EXPECT_GE(
      snr_db(evaluate_values({samples, 0, make_kernel("default"), 0, large_cache}, points, context.get()),
             points, f),
      51);
}

TEST(CcVolume, PaperIsTheGaussianOfThePaper) {
  // One site of value 1 becomes the normalised Gaussian in space and the hat in time.
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::cc, {13, 13, 13, 9});
  const auto samples = sample_field(lattice, [](const Vec4& p) { return p == Vec4{6, 6, 6, 4} ? 1.0 : 0.0; });
  const Coefficients c(samples, 0, make_kernel("paper"), 0, large_cache);
  std::vector<Vec4> points;
  for (int i = 0; i < 60; ++i) points.push_back({5 + 0.03 * i, 6.2, 5.9, 3.1 + 0.03 * i});
  const auto values = evaluate_values(c, points, context.get());
  for (size_t n = 0; n < points.size(); ++n) {
    const Vec4& p = points[n];
    const auto weight = [&](double x, double y, double z) {
      const double r2 = (p[0] - x) * (p[0] - x) + (p[1] - y) * (p[1] - y) + (p[2] - z) * (p[2] - z);
      return r2 < 4 ? std::exp(-2 * r2) : 0;
    };
    double sum = 0;
    for (int x = 3; x <= 9; ++x)
      for (int y = 3; y <= 9; ++y)
        for (int z = 3; z <= 9; ++z) sum += weight(x, y, z);
    const double expected = weight(6, 6, 6) / sum * std::max(0.0, 1 - std::fabs(p[3] - 4));
    EXPECT_NEAR(values[n], expected, 2e-3 * expected + 1e-6);
  }
}

TEST(CcVolume, PlaneSlicesOfEitherLatticeOntoEither) {
  TestContext context;
  const PlaneWaves f(12, 0.5, 3);
  const Hyperplane h{0.5, 0.5, 0.5, 0.5, -31};
  for (const LatticeKind source : {LatticeKind::cc, LatticeKind::d4star})
    for (const LatticeKind target : {LatticeKind::cc, LatticeKind::bcc}) {
      const auto lattice = Lattice4::fit(source, {32, 32, 32, 32});
      const auto samples = sample_field(lattice, f);
      const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
      HypersliceOptions options;
      options.target = target;
      const Slice slice = plane_slice(c, h, options, {}, context.get());
      EXPECT_EQ(slice.lattice.bcc, target == LatticeKind::bcc);
      std::mt19937 random(5);
      std::vector<Vec3> uvw;
      std::vector<Vec4> points;
      while (points.size() < 1000) {
        Vec3 u;
        Vec4 p = slice.origin;
        for (size_t k = 0; k < 3; ++k) {
          u[k] = slice.lattice_to_slice.offset[k] +
                 std::uniform_real_distribution<double>(0, slice.domain_end[k])(random) *
                     slice.lattice_to_slice.linear[k][k];
          for (size_t i = 0; i < 4; ++i) p[i] += u[k] * slice.basis[k][i];
        }
        bool inside = true;
        for (const double v : p) inside = inside && v > 9 && v < 22;
        if (inside) uvw.push_back(u), points.push_back(p);
      }
      std::vector<float> values(points.size());
      EXPECT_EQ(sample_points(slice, uvw, values, {}, context.get()).outside, 0u);
      EXPECT_GE(snr_db(values, points, f), 39)
          << static_cast<int>(source) << " onto " << static_cast<int>(target);
    }
}

} // namespace
} // namespace bccsplat
