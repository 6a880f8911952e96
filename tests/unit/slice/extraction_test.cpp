// SPDX-License-Identifier: Apache-2.0
// The paper's extraction is compared with its formula, summed the slow way.
#include "slice/extraction.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/support/fields.h"
#include "tests/unit/slice/hyperplanes.h"
#include "view/view.h"

namespace bccsplat {
namespace {

using test::PlaneWaves;
using test::sample_field;
using test::TestContext;
using test::through;

class ExtractionTest : public testing::Test {
 protected:
  TestContext context;
  Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {20, 18, 19, 17}, {1, 1, 1, 1.1});

  // Returns points of slice space, `margin` inside the domain.
  std::vector<Vec3> points_of(const PlaneAxes& axes, double margin, size_t count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-30, 30);
    std::vector<Vec3> points;
    while (points.size() < count) {
      const Vec3 uvw{uniform(random), uniform(random), uniform(random)};
      bool inside = true;
      for (size_t i = 0; i < 4; ++i) {
        double p = axes.origin[i];
        for (size_t k = 0; k < 3; ++k) p += uvw[k] * axes.basis[k][i];
        inside = inside && p >= margin && p <= lattice.dims[i] - 1.0 - margin;
      }
      if (inside) points.push_back(uvw);
    }
    return points;
  }
};

// Values are the sum over the 4D Gaussian, on either lattice, with mirror images beyond the ends, and
// gradients are their differences.
class ExtractionSum : public ExtractionTest, public testing::WithParamInterface<LatticeKind> {};

INSTANTIATE_TEST_SUITE_P(Lattices, ExtractionSum, testing::Values(LatticeKind::d4star, LatticeKind::cc));

TEST_P(ExtractionSum, IsTheSumOverThe4DGaussian) {
  const PlaneWaves f(6, 0.5, 3);
  lattice = Lattice4::fit(GetParam(), lattice.dims, {1, 1, 1, GetParam() == LatticeKind::cc ? 1 : 1.1});
  const double time_unit = lattice.layer_distance() / lattice.time_step; // T per frame
  const auto samples = sample_field(
      lattice, [&](const Vec4& p) { return f(p) + 5; }, 5);
  for (const Vec4& normal : {Vec4{0, 0, 0, 1}, Vec4{1, 0, 0, 0}, Vec4{1, -2, 0.5, 1}}) {
    const Hyperplane h = through(normal, {9, 8.6, 9.2, 8});
    const PlaneAxes axes = plane_axes(h);
    const Extraction extraction(samples, 0, h, axes, context.get());
    const auto points = points_of(axes, 0.03, 90);
    std::vector<float> values(points.size()), moved(points.size());
    std::vector<std::array<float, 3>> gradients(points.size());
    EXPECT_EQ(extraction.sample(points, values, gradients, context.get()), 0u);
    for (size_t a = 0; a < 3; ++a) {
      constexpr double off = 0.02;
      std::vector<Vec3> at = points;
      for (Vec3& p : at) p[a] += off;
      EXPECT_EQ(extraction.sample(at, moved, {}, context.get()), 0u);
      std::vector<float> after = moved;
      for (Vec3& p : at) p[a] -= 2 * off;
      EXPECT_EQ(extraction.sample(at, moved, {}, context.get()), 0u);
      for (size_t n = 0; n < points.size(); ++n)
        ASSERT_NEAR(gradients[n][a], (after[n] - moved[n]) / (2 * off), 0.05) << n; // points drop out at 2 T
    }
    const Vec3 unit = lattice.lattice_unit();
    for (size_t n = 0; n < points.size(); ++n) {
      Vec4 q = axes.origin;
      for (size_t i = 0; i < 4; ++i)
        for (size_t k = 0; k < 3; ++k) q[i] += points[n][k] * axes.basis[k][i];
      double sum = 0, weights = 0;
      constexpr int beyond = 3; // sites of which images are in reach
      for (int32_t m = -beyond; m < lattice.layers() + beyond; ++m) {
        const int c = lattice.coset(m + 2 * beyond);
        const Int3 sites = lattice.space.dims(c);
        for (int z = -beyond; z < sites[2] + beyond; ++z)
          for (int y = -beyond; y < sites[1] + beyond; ++y)
            for (int x = -beyond; x < sites[0] + beyond; ++x) {
              const Vec3 s = lattice.site_position(c, {x, y, z});
              const double t = (q[3] - lattice.layer_frame(m)) * time_unit;
              double r2 = t * t;
              for (size_t a = 0; a < 3; ++a) r2 += std::pow((q[a] - s[a]) / unit[a], 2);
              if (!(r2 < 4)) continue;
              const Vec3 own =
                  lattice.site_position(c, {lattice.space.mirror(0, c, x), lattice.space.mirror(1, c, y),
                                            lattice.space.mirror(2, c, z)});
              weights += std::exp(-2 * r2);
              sum += std::exp(-2 * r2) *
                     f({own[0], own[1], own[2], lattice.layer_frame(lattice.mirror_layer(m))});
            }
      }
      ASSERT_NEAR(values[n], 5 + sum / weights, 0.01 * std::fabs(sum / weights) + 1e-3);
    }
  }
}

TEST_F(ExtractionTest, ListsThePointsInReach) {
  const auto samples = sample_field(lattice, [](const Vec4&) { return 3.0; });
  const Hyperplane h = through({1, 1, 0, 1}, {9, 8.6, 9.2, 8});
  const PlaneAxes axes = plane_axes(h);
  const Extraction extraction(samples, 0, h, axes, context.get());
  std::vector<float> uvw(3 * extraction.points()), weighted(extraction.points());
  ASSERT_EQ(extraction.list(extraction.points(), uvw.data(), weighted.data(), context.get().progress),
            extraction.points());
  // All sites that are within 2 T of the hyperplane, and their mirror images that are no further beyond the
  // ends.
  const Vec3 unit = lattice.lattice_unit();
  const Vec4 unit4{unit[0], unit[1], unit[2], lattice.time_step / lattice.layer_distance()};
  double across = 0;
  for (size_t i = 0; i < 4; ++i) across += std::pow(h[i] * unit4[i], 2);
  const auto in_reach = [&](const Vec4& s) {
    for (size_t a = 0; a < 4; ++a)
      if (s[a] <= -2 * unit4[a] || s[a] >= lattice.domain_end(a) + 2 * unit4[a]) return false;
    const double d = h[0] * s[0] + h[1] * s[1] + h[2] * s[2] + h[3] * s[3] + h[4];
    return d * d < 4 * across;
  };
  size_t count = 0;
  constexpr int beyond = 3;
  for (int32_t m = -beyond; m < lattice.layers() + beyond; ++m) {
    const int c = lattice.coset(m + 2 * beyond);
    const Int3 sites = lattice.space.dims(c);
    for (int z = -beyond; z < sites[2] + beyond; ++z)
      for (int y = -beyond; y < sites[1] + beyond; ++y)
        for (int x = -beyond; x < sites[0] + beyond; ++x) {
          const Vec3 s = lattice.site_position(c, {x, y, z});
          count += in_reach({s[0], s[1], s[2], lattice.layer_frame(m)}) ? 1 : 0;
        }
  }
  EXPECT_EQ(extraction.points(), count);
  double high = 0, low = 10;
  for (size_t n = 0; n < weighted.size(); ++n) {
    high = std::max<double>(high, weighted[n]), low = std::min<double>(low, weighted[n]);
    for (size_t i = 0; i < 4; ++i) { // in the domain, but for the projection along the normal
      double p = axes.origin[i];
      for (size_t k = 0; k < 3; ++k) p += uvw[3 * n + k] * axes.basis[k][i];
      ASSERT_GE(p, -4);
      ASSERT_LE(p, lattice.dims[i] + 3.0);
    }
  }
  EXPECT_LE(high, 3.0001);
  EXPECT_GE(low, 3 * std::exp(-8.0) * 0.999);
  EXPECT_GT(high, 2.9);
  EXPECT_LT(low, 0.01);
}

// A constant is one up to the ends of the domain: in the corners too nothing falls off, nor where images of
// images are in reach.
TEST_P(ExtractionSum, ConstantsReachTheEnds) {
  for (const std::array<uint32_t, 4>& dims : {std::array<uint32_t, 4>{20, 18, 19, 17}, {2, 18, 1, 17}}) {
    lattice = Lattice4::fit(GetParam(), dims);
    const auto samples = sample_field(lattice, [](const Vec4&) { return 3.0; });
    for (const double t : {0.0, 7.3, 16.0}) {
      const Hyperplane h{0, 0, 0, 1, -t};
      const Extraction extraction(samples, 0, h, plane_axes(h), context.get());
      const auto box = box_corners({0, 0, 0}, {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0});
      const std::vector<Vec3> corners(box.begin(), box.end());
      std::vector<float> values(corners.size());
      EXPECT_EQ(extraction.sample(corners, values, {}, context.get()), 0u);
      for (const float v : values) EXPECT_NEAR(v, 3, 0.02) << t;
    }
  }
}

TEST_F(ExtractionTest, OutsideAndUnsupported) {
  const auto samples = sample_field(lattice, [](const Vec4&) { return 3.0; });
  const Hyperplane far{1, 0, 0, 0, 99};
  const Extraction none(samples, 0, far, plane_axes(far), context.get());
  EXPECT_EQ(none.points(), 0u);
  const std::vector<Vec3> at{{5, 5, 5}};
  std::vector<float> v(1);
  EXPECT_EQ(none.sample(at, v, {}, context.get()), 1u);
  EXPECT_TRUE(std::isnan(v[0]));
  const auto still =
      sample_field(Lattice4::fit(LatticeKind::bcc, {8, 8, 8, 1}), [](const Vec4&) { return 1.0; });
  const Hyperplane h{0, 0, 0, 1, -4};
  EXPECT_THROW(Extraction(still, 0, h, plane_axes(h), context.get()), Error);
}

// Points are reserved before they are made: where the budget ends nothing has grown beyond it.
TEST_F(ExtractionTest, KeepsToTheMemoryBudget) {
  const auto samples = sample_field(lattice, [](const Vec4&) { return 3.0; });
  const Hyperplane h = through({1, 1, 0, 1}, {9, 8.6, 9.2, 8});
  uint64_t bytes = 0, points = 0, peak = 0;
  {
    const Extraction whole(samples, 0, h, plane_axes(h), context.get());
    bytes = whole.bytes(), points = whole.points(), peak = context.memory.peak();
    EXPECT_EQ(context.memory.used(), bytes);
    EXPECT_GE(bytes, points * sizeof(Extraction::Point));
    EXPECT_GE(peak, 2 * points * sizeof(Extraction::Point)); // as found, and by cell
  }
  EXPECT_EQ(context.memory.used(), 0u);
  for (const uint64_t limit : {peak - 1, bytes / 2}) {
    TestContext small(2, limit);
    EXPECT_THROW(Extraction(samples, 0, h, plane_axes(h), small.get()), Error);
    EXPECT_LE(small.memory.peak(), limit);
    EXPECT_EQ(small.memory.used(), 0u);
  }
}

TEST_F(ExtractionTest, ThreadsDoNotChangeAPoint) {
  const PlaneWaves f(6, 0.5, 3);
  const auto samples = sample_field(lattice, [&](const Vec4& p) { return f(p); });
  const Hyperplane h = through({1, 1, 0, 1}, {9, 8.6, 9.2, 8});
  const auto list_of = [&](int threads) {
    TestContext with(threads);
    const Extraction e(samples, 0, h, plane_axes(h), with.get());
    std::vector<float> list(4 * e.points());
    (void)e.list(e.points(), list.data(), list.data() + 3 * e.points(), with.progress);
    return list;
  };
  EXPECT_EQ(list_of(1), list_of(3));
}

} // namespace
} // namespace bccsplat
