#include "slice/plane_slice.h"

#include <gtest/gtest.h>

#include "slice/evaluate.h"
#include "slice/sample_grid.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::PlaneWaves;
using test::sample_field;
using test::TestContext;

constexpr uint64_t large_cache = 1u << 30;

std::array<double, 5> through(const Vec4& normal, const Vec4& point) {
  double length = 0;
  for (const double v : normal) length += v * v;
  length = std::sqrt(length);
  std::array<double, 5> h{};
  for (size_t i = 0; i < 4; ++i) h[i] = normal[i] / length, h[4] -= h[i] * point[i];
  return h;
}

Vec4 index_point(const Slice& s, const Vec3& uvw) {
  Vec4 p = s.origin;
  for (size_t k = 0; k < 3; ++k)
    for (size_t i = 0; i < 4; ++i) p[i] += uvw[k] * s.basis[k][i];
  return p;
}

// SNR of the slice against f at random points at least `margin` inside the domain.
double slice_snr(const Slice& s, const Lattice4& lattice, const test::Field4& f, double margin,
                 const Context& context) {
  std::mt19937 random(5);
  std::vector<Vec3> points;
  for (int tries = 0; tries < 200000 && points.size() < 2000; ++tries) {
    Vec3 p;
    for (size_t a = 0; a < 3; ++a)
      p[a] =
          s.lattice_to_slice.offset[a] + std::uniform_real_distribution<double>(0, s.domain_end[a])(random) *
                                             s.lattice_to_slice.linear[a][a];
    const Vec4 q = index_point(s, p);
    bool inside = true;
    for (size_t i = 0; i < 4; ++i)
      inside = inside && q[i] >= margin && q[i] <= lattice.dims[i] - 1.0 - margin;
    if (inside) points.push_back(p);
  }
  EXPECT_GE(points.size(), 200u);
  std::vector<float> values(points.size());
  sample_points(s, points, values, {}, context);
  double signal = 0, error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double truth = f(index_point(s, points[i]));
    signal += truth * truth, error += (values[i] - truth) * (values[i] - truth);
  }
  return 10 * std::log10(signal / error);
}

class PlaneSlice : public testing::Test {
 protected:
  TestContext context;
  Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {32, 32, 32, 32});
  PlaneWaves waves{12, 0.5, 3};
  MemorySamples samples = sample_field(lattice, waves);
  Coefficients coefficients{samples, 0, make_kernel("default"), 0, large_cache};

  double evaluate_snr() {
    const auto points = test::random_points(lattice, 4000, 7, 9);
    std::vector<float> v(points.size());
    evaluate4(coefficients, points, v, {}, context.get());
    double signal = 0, error = 0;
    for (size_t i = 0; i < v.size(); ++i) {
      const double f = waves(points[i]);
      signal += f * f, error += (v[i] - f) * (v[i] - f);
    }
    return 10 * std::log10(signal / error);
  }
  Slice cut(const std::array<double, 5>& h) { return plane_slice(coefficients, h, {}, {}, context.get()); }
};

TEST_F(PlaneSlice, ObliqueWithinThreeDecibelsOfTheVolume) {
  const double best = evaluate_snr();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 5; ++k) {
    const Vec4 n{normal(random), normal(random), normal(random), normal(random)};
    EXPECT_GE(slice_snr(cut(through(n, {15.5, 16, 15, 15.7})), lattice, waves, 9, context.get()), best - 3)
        << "plane " << k;
  }
}

TEST_F(PlaneSlice, AxisSlicesWithinOneDecibel) {
  const double best = evaluate_snr();
  for (size_t axis = 0; axis < 3; ++axis) {
    Vec4 n{};
    n[axis] = -2; // any length and sign
    const Slice s = cut(through(n, {14.3, 16.1, 15.9, 0}));
    EXPECT_GE(slice_snr(s, lattice, waves, 9, context.get()), best - 1.5) << "axis " << axis;
    for (size_t k = 0; k < 3; ++k) // coordinates of the slice are those of the remaining axes
      EXPECT_NEAR(s.basis[k][k < axis ? k : k + 1], 1, 1e-12);
    EXPECT_NEAR(s.origin[axis], (std::array{14.3, 16.1, 15.9})[axis], 1e-12);
  }
}

TEST_F(PlaneSlice, ConstantFieldIsConstant) {
  const auto flat = sample_field(lattice, [](const Vec4&) { return 4.0; });
  const Coefficients c(flat, 0, make_kernel("default"), 0, large_cache);
  const Slice s = plane_slice(c, through({1, 2, -1, 3}, {15, 15, 15, 15}), {}, {}, context.get());
  std::vector<float> v(30 * 30 * 30);
  Grid grid;
  for (size_t a = 0; a < 3; ++a) {
    grid.origin[a] = s.lattice_to_slice.offset[a];
    grid.dims[a] = 30;
    grid.step[a] = s.domain_end[a] * s.lattice_to_slice.linear[a][a] / 29;
  }
  sample_grid(s, grid, v.data(), context.get());
  size_t inside = 0;
  for (const float x : v)
    if (!std::isnan(x)) {
      ++inside;
      ASSERT_NEAR(x, 4, 0.02); // the ripple of two reconstructions
    }
  EXPECT_GT(inside, v.size() / 20);
}

TEST_F(PlaneSlice, NearlyAxisAlignedAgreesWithTheAxis) {
  const Slice a = cut({1, 0, 0, 0, -12.25});
  const Slice b = cut(through({1, 1e-9, -1e-9, 1e-9}, {12.25, 0, 0, 0}));
  std::vector<float> va(1000), vb(1000);
  Grid grid;
  grid.origin = {2, 3, 4}, grid.step = {2.5, 2.5, 2.5}, grid.dims = {10, 10, 10};
  sample_grid(a, grid, va.data(), context.get());
  sample_grid(b, grid, vb.data(), context.get());
  for (size_t i = 0; i < va.size(); ++i) ASSERT_NEAR(va[i], vb[i], 1e-5);
}

TEST_F(PlaneSlice, OutsideTheDomainIsEmpty) {
  for (const double at : {-3.0, 40.0}) {
    const Slice s = cut({1, 0, 0, 0, -at});
    EXPECT_EQ(s.points(), 0);
  }
  const Slice corner = cut(through({1, 1, 1, 1}, {31.0001, 31, 31, 31}));
  EXPECT_EQ(corner.points(), 0);
}

TEST_F(PlaneSlice, ReadsOnlyTheBricksItTouches) {
  // The region given to the source, as recorded by a source that watches.
  struct Watching final : SampleSource {
    const MemorySamples& inner;
    mutable BrickBox seen{{1000, 0, 0}, {0, 0, 0}};
    explicit Watching(const MemorySamples& s) : inner(s) {}
    const Lattice4& lattice() const override { return inner.lattice(); }
    int channels() const override { return 1; }
    float air(int c) const override { return inner.air(c); }
    const std::string& coefficient_kernel() const override { return inner.coefficient_kernel(); }
    BrickLayer read_layer(int c, int32_t layer, const BrickBox& region, const Context& ctx) const override {
      seen = region;
      const BrickLayer whole = inner.read_layer(c, layer, region, ctx);
      BrickLayer part(whole.lattice(), whole.coset());
      for (size_t s = 0; s < whole.brick_slots(); ++s)
        if (region.contains(whole.slot_position(s))) part.set(s, whole.share(s));
      return part;
    }
  };
  const auto long_lattice = Lattice4::fit(LatticeKind::d4star, {160, 20, 20, 6});
  const auto field = sample_field(long_lattice, PlaneWaves(6, 0.5, 13));
  const Watching source(field);
  const Coefficients partial(source, 0, make_kernel("default"), 0, large_cache);
  const Coefficients whole(field, 0, make_kernel("default"), 0, large_cache);
  const Slice a = plane_slice(partial, {1, 0, 0, 0, -78.2}, {}, {}, context.get());
  EXPECT_GE(source.seen.begin[0], 2);
  EXPECT_LE(source.seen.end[0] - source.seen.begin[0], 2);
  // What is not read does not matter: the whole volume gives the same coefficients, bit for bit.
  const Slice b = plane_slice(whole, {1, 0, 0, 0, -78.2}, {}, {}, context.get());
  for (size_t c = 0; c < 2; ++c) EXPECT_EQ(layer_to_dense(a.coset[c]), layer_to_dense(b.coset[c]));
  // The whole slice passes through the same code, though: the volume's own values are further evidence.
  std::vector<Vec4> points;
  std::vector<Vec3> uvw;
  for (int i = 0; i < 200; ++i) {
    uvw.push_back({4 + 0.055 * i, 15 - 0.05 * i, 2 + 0.005 * i});
    points.push_back({78.2, uvw.back()[0], uvw.back()[1], uvw.back()[2]});
  }
  std::vector<float> va(200), vw(200);
  sample_points(a, uvw, va, {}, context.get());
  evaluate4(whole, points, vw, {}, context.get());
  for (size_t i = 0; i < 200; ++i) ASSERT_NEAR(va[i], vw[i], 0.03) << i;
}

TEST_F(PlaneSlice, DisplayKeepsLengthsAndAngles) {
  Affine3 world; // anisotropic and sheared
  world.linear = {Vec3{2, 0.5, 0}, Vec3{0, 3, 0}, Vec3{0, 0, 0.7}};
  const PlaneOptions options{.spacing = 1, .time_length = 5};
  const Slice s = plane_slice(coefficients, through({1, 0.3, -0.2, 0.5}, {15, 15, 15, 15}), options, world,
                              context.get());
  const auto metric = [&](const Vec4& a, const Vec4& b) {
    return dot(world.vector({a[0], a[1], a[2]}), world.vector({b[0], b[1], b[2]})) + 25 * a[3] * b[3];
  };
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) {
      Vec3 ei{}, ej{};
      ei[i] = 1, ej[j] = 1;
      EXPECT_NEAR(dot(s.slice_to_world.vector(ei), s.slice_to_world.vector(ej)),
                  metric(s.basis[i], s.basis[j]), 1e-9);
    }
}

} // namespace
} // namespace bccsplat
