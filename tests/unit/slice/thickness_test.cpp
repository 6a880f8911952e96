// SPDX-License-Identifier: Apache-2.0
// Thick slices: means, sums and maxima along the normal, of time, axis and oblique slices.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "field/sample_grid.h"
#include "slice/hyperslice.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::large_cache;
using test::PlaneWaves;
using test::sample_field;
using test::TestContext;

TEST(Quadrature, GaussLegendreIntegratesPolynomials) {
  for (const int n : {1, 2, 5, 40}) {
    const Quadrature q = gauss_legendre(n);
    for (int power = 0; power < 2 * n; ++power) {
      double sum = 0;
      for (size_t i = 0; i < q.node.size(); ++i) sum += q.weight[i] * std::pow(q.node[i], power);
      EXPECT_NEAR(sum, 1.0 / (power + 1), 1e-13) << n << " nodes, power " << power;
    }
  }
  EXPECT_THROW((void)thickness_nodes(1e6, 1), Error);
}

TEST(Quadrature, NodesResolveTheNyquistFrequency) {
  for (const double length : {0.3, 2.0, 7.5, 40.0}) {
    const Quadrature q = gauss_legendre(thickness_nodes(length, 1));
    double sum = 0;
    for (size_t i = 0; i < q.node.size(); ++i)
      sum += q.weight[i] * std::cos(std::numbers::pi * length * q.node[i] + 0.3);
    const double w = std::numbers::pi * length;
    EXPECT_NEAR(sum, (std::sin(w + 0.3) - std::sin(0.3)) / w, 1e-4) << length;
  }
}

TEST(Quadrature, FinerLatticesTakeMoreNodes) {
  EXPECT_EQ(thickness_nodes(10, 1), thickness_nodes(10, 1.4));
  for (const double density : {1.4, 2.0, 4.0}) {
    const Quadrature q = gauss_legendre(thickness_nodes(10, density));
    const double w = density * std::numbers::pi * 10;
    double sum = 0;
    for (size_t i = 0; i < q.node.size(); ++i) sum += q.weight[i] * std::cos(w * q.node[i] + 0.3);
    EXPECT_NEAR(sum, (std::sin(w + 0.3) - std::sin(0.3)) / w, 1e-3) << density;
  }
}

struct Plane {
  const char* name;
  Hyperplane h;
  double tolerance; // of a mean against the mean of thin slices, whose lattices differ by a shift
  double of_sum; // against the mean; lengths have creases at the ends of the domain, which spread by a filter
};
const Plane planes[] = {{"time", {0, 0, 0, 1, -8.3}, 2e-4, 1e-4},
                        {"axis", {0, -1, 0, 0, 9.4}, 2e-4, 1e-4},
                        {"oblique", {0.5, 0.5, -0.5, 0.5, -9.2}, 0.02, 0.03}};

class ThickSlice : public testing::TestWithParam<Plane> {
 protected:
  TestContext context;
  Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {18, 20, 19, 17});

  Slice cut(const Coefficients& c, const Hyperplane& h, double thickness, ThicknessKind kind) {
    HypersliceOptions options;
    options.thickness = {thickness, kind};
    return hyperslice(c, h, options, {}, context.get());
  }
  Slice cut(const MemorySamples& samples, double thickness, ThicknessKind kind) {
    return cut(Coefficients(samples, 0, make_kernel("default"), 0, large_cache), GetParam().h, thickness,
               kind);
  }
  // Returns points of slice space whose line of length `thickness` lies inside the domain.
  std::vector<Vec3> inner_points(const Slice& s, double thickness, size_t count) {
    std::mt19937 random(3);
    std::vector<Vec3> points;
    for (int tries = 0; tries < 400000 && points.size() < count; ++tries) {
      Vec3 p;
      for (size_t a = 0; a < 3; ++a)
        p[a] = s.lattice_to_slice.offset[a] +
               std::uniform_real_distribution<double>(0, s.domain_end[a])(random) *
                   s.lattice_to_slice.linear[a][a];
      bool inside = true;
      for (size_t i = 0; i < 4; ++i) {
        double q = s.origin[i];
        for (size_t k = 0; k < 3; ++k) q += p[k] * s.basis[k][i];
        const double room = thickness / 2 * std::fabs(s.hyperplane[i]) + (s.clip.empty() ? 0 : 2);
        inside = inside && q >= room && q <= lattice.dims[i] - 1.0 - room;
      }
      if (inside) points.push_back(p);
    }
    EXPECT_EQ(points.size(), count);
    return points;
  }
  std::vector<float> values(const Slice& s, const std::vector<Vec3>& points) {
    std::vector<float> v(points.size());
    EXPECT_EQ(sample_points(s, points, v, {}, context.get()).outside, 0u);
    return v;
  }
};
INSTANTIATE_TEST_SUITE_P(Planes, ThickSlice, testing::ValuesIn(planes),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(ThickSlice, OfAConstant) {
  for (const double air : {0.0, 1.0}) {
    const auto flat = sample_field(
        lattice, [](const Vec4&) { return 4.0; }, air);
    const double thickness = 2.5;
    const Slice mean = cut(flat, thickness, ThicknessKind::mean),
                sum = cut(flat, thickness, ThicknessKind::sum),
                maximum = cut(flat, thickness, ThicknessKind::maximum);
    const auto points = inner_points(mean, thickness, 300);
    const auto a = values(mean, points), b = values(sum, points), c = values(maximum, points);
    for (size_t i = 0; i < points.size(); ++i) { // the ripples of two reconstructions
      ASSERT_NEAR(a[i], 4, 0.03);
      ASSERT_NEAR(b[i], 4 * thickness, 0.03 * thickness + 4 * GetParam().of_sum);
      ASSERT_NEAR(c[i], 4, 0.03);
    }
  }
}

TEST_P(ThickSlice, Linear) {
  const PlaneWaves f(5, 0.6, 29), g(5, 0.6, 31);
  const auto a = cut(sample_field(lattice, f), 3, ThicknessKind::sum);
  const auto b = cut(sample_field(lattice, g), 3, ThicknessKind::sum);
  const auto both =
      cut(sample_field(lattice, [&](const Vec4& p) { return 2 * f(p) - 3 * g(p); }), 3, ThicknessKind::sum);
  const auto points = inner_points(a, 3, 200);
  const auto va = values(a, points), vb = values(b, points), v = values(both, points);
  for (size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(v[i], 2 * va[i] - 3 * vb[i], 2e-4);
}

TEST_P(ThickSlice, MeanIsTheMeanOfThinSlices) {
  const auto samples = sample_field(lattice, PlaneWaves(6, 0.4, 61));
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  const double thickness = 3;
  const Hyperplane h = GetParam().h;
  const Slice mean = cut(c, h, thickness, ThicknessKind::mean),
              sum = cut(c, h, thickness, ThicknessKind::sum),
              maximum = cut(c, h, thickness, ThicknessKind::maximum);
  const auto points = inner_points(mean, thickness, 100);
  constexpr int count = 64;
  std::vector<double> expected(points.size()), largest(points.size(), -1e9);
  for (int k = 0; k < count; ++k) {
    const double shift = thickness * ((k + 0.5) / count - 0.5);
    const auto v = values(cut(c, h.moved(shift), 0, ThicknessKind::mean), points);
    for (size_t i = 0; i < v.size(); ++i) {
      expected[i] += v[i] / double{count};
      largest[i] = std::max<double>(largest[i], v[i]);
    }
  }
  const auto m = values(mean, points), s = values(sum, points), x = values(maximum, points);
  double crease = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(m[i], expected[i], GetParam().tolerance);
    EXPECT_NEAR(s[i], thickness * m[i], GetParam().of_sum);
    crease += std::pow(x[i] - largest[i], 2) / static_cast<double>(points.size());
  }
  EXPECT_LT(std::sqrt(crease), 0.1); // maxima have creases, which the lattice cannot follow
}

TEST_P(ThickSlice, MaximumIsNoLessThanTheMean) {
  const auto samples = sample_field(lattice, PlaneWaves(6, 0.7, 67));
  const Slice mean = cut(samples, 3, ThicknessKind::mean), maximum = cut(samples, 3, ThicknessKind::maximum);
  const auto points = inner_points(mean, 3, 300);
  const auto a = values(mean, points), b = values(maximum, points);
  double gain = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_GE(b[i], a[i] - 0.05); // between sites the interpolation may dip
    gain += (b[i] - a[i]) / static_cast<double>(points.size());
  }
  EXPECT_GT(gain, 0.3);
}

TEST_P(ThickSlice, IsClippedToTheDomain) {
  // In a cut far thicker than the volume, the mean of a field that is level along the normal's axes stays
  // what it is only if nothing beyond the ends counts.
  const auto flat = sample_field(lattice, [](const Vec4&) { return 2.0; });
  const Slice mean = cut(flat, 500, ThicknessKind::mean), sum = cut(flat, 500, ThicknessKind::sum);
  const auto points = inner_points(mean, 0, 100);
  const auto a = values(mean, points), b = values(sum, points);
  for (size_t i = 0; i < points.size(); ++i) {
    double low = -500, high = 500; // of the line through the point
    for (size_t axis = 0; axis < 4; ++axis) {
      double q = mean.origin[axis];
      for (size_t k = 0; k < 3; ++k) q += points[i][k] * mean.basis[k][axis];
      const double n = mean.hyperplane[axis];
      if (n == 0) continue;
      const double x = -q / n, y = (lattice.dims[axis] - 1.0 - q) / n;
      low = std::max(low, std::min(x, y)), high = std::min(high, std::max(x, y));
    }
    ASSERT_NEAR(a[i], 2, 0.02);
    ASSERT_NEAR(b[i], 2 * (high - low), 0.2 + 40 * GetParam().of_sum); // of up to 40
  }
}

TEST(ThicknessOptions, AreChecked) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {8, 8, 8, 8});
  const auto samples = sample_field(lattice, [](const Vec4&) { return 1.0; });
  const Coefficients c(samples, 0, make_kernel("default"), 0, large_cache);
  const auto refused = [&](const Hyperplane& h, const HypersliceOptions& o) {
    try {
      (void)hyperslice(c, h, o, {}, context.get());
    } catch (const Error& e) {
      return e.code();
    }
    return Code::ok;
  };
  HypersliceOptions o;
  o.thickness.length = -1;
  EXPECT_EQ(refused({0, 0, 0, 1, -2}, o), Code::invalid_argument);
  o.thickness.length = 1;
  o.interval = {-1, 0};
  EXPECT_EQ(refused({0, 0, 0, 1, -2}, o), Code::invalid_argument);
  o.thickness.length = 0;
  EXPECT_EQ(refused({0, 0, 0, 1, -2}, o), Code::ok);
  EXPECT_EQ(refused({0, 0, 1, 0, -2}, o), Code::unsupported);
  o.interval = {0, 0};
  o.spacing = std::nan("");
  EXPECT_EQ(refused({0, 0, 1, 0, -2}, o), Code::invalid_argument);
  EXPECT_EQ(refused({0, 0, 0, 1, -9}, {}), Code::out_of_domain);
  EXPECT_EQ(refused({0, 0, 1, 0, -9}, {}), Code::ok); // empty
}

// What is missing at every instant stays missing, and what is there at one of them is not.
TEST(ThickMaximum, OfHolesIsAHole) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {24, 24, 24, 16});
  const MemorySamples whole = test::sample_field(lattice, [](const Vec4&) { return 2.0; });
  std::vector<std::vector<BrickLayer>> layers(1);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    BrickLayer layer = whole.read_layer(0, m, {}, context.get());
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      auto brick = std::make_shared<Brick>();
      brick->value = layer.brick(slot)->value, brick->kept = layer.brick(slot)->kept;
      brick->hole = std::make_unique<BrickMask>();
      const Int3 b = layer.slot_position(slot);
      for (int s = 0; s < brick_sites; ++s) {
        const Int3 i{b[0] * brick_edge + s % brick_edge, b[1] * brick_edge + s / brick_edge % brick_edge,
                     b[2] * brick_edge + s / brick_rows};
        const Vec3 p = lattice.site_position(layer.coset(), i);
        const bool always = p[0]<8, at_first = p[0]> 16 && lattice.layer_frame(m) < 7;
        if (always || at_first)
          (*brick->hole)[s / brick_edge] |= static_cast<uint16_t>(1u << (s % brick_edge));
      }
      layer.set(slot, std::move(brick));
    }
    layers[0].push_back(std::move(layer));
  }
  const MemorySamples samples(lattice, {0}, std::move(layers));
  HypersliceOptions options;
  options.thickness = {6, ThicknessKind::maximum};
  const Slice slice = hyperslice(Coefficients(samples, 0, make_kernel("default"), 0, large_cache),
                                 {0, 0, 0, 1, -8}, options, {}, context.get());
  const Vec3 points[] = {{3, 12, 12}, {12, 12, 12}, {20, 12, 12}};
  float values[3];
  EXPECT_EQ(evaluate(slice, points, values, {}).holes, 1u);
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_NEAR(values[1], 2, 0.01);
  EXPECT_NEAR(values[2], 2, 0.01);
}

} // namespace
} // namespace bccsplat
