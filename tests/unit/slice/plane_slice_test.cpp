// SPDX-License-Identifier: Apache-2.0
// Slices of any hyperplane: how near they are to the field, that nearly axis-aligned ones agree with the
// axis, what they read, and their place in the world.
#include "slice/plane_slice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "base/error.h"
#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "kernel/kernel_time.h"
#include "slice/hyperslice.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"
#include "tests/unit/slice/hyperplanes.h"

namespace bccsplat {
namespace {

using test::large_cache;
using test::PlaneWaves;
using test::sample_field;
using test::TestContext;
using test::through;

Hyperplane across(size_t axis, double at) {
  return {1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2), 0, -at};
}

Vec4 index_point(const Slice& s, const Vec3& uvw) {
  Vec4 p = s.origin;
  for (size_t k = 0; k < 3; ++k)
    for (size_t i = 0; i < 4; ++i) p[i] += uvw[k] * s.basis[k][i];
  return p;
}

// Returns the SNR of the slice against f at random points at least `margin` inside the domain.
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
  Slice cut(const Hyperplane& h) { return hyperslice(coefficients, h, {}, {}, context.get()); }
};

// Equation (6) of Neophytou & Mueller 2002: with their kernel a resampled slice holds, at the sites of its
// own lattice, the mean of the 4D samples within 2 T in space and in time, weighted by exp(-2 r^2). Each
// coset's layers weigh 1 together; in space the sum of all weights divides, less the share that is beyond 2 T
// on average.
TEST_F(PlaneSlice, OfThePaperIsItsEquation) {
  const Coefficients paper{samples, 0, make_kernel("paper"), 0, large_cache};
  const Slice s = plane_slice(paper, through({1, 0.5, -0.3, 0.8}, {16, 15, 16, 17}), {}, {}, context.get());
  const Vec3 unit = lattice.lattice_unit();
  // At q: of a coset's layers the sum of weights; of its sites in space the sums of weights and of weighted
  // samples.
  const auto mean_at = [&](const Vec4& q) {
    std::array<double, 2> layers{}, sums{};
    double space = 0;
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const double t = (q[3] - lattice.layer_frame(m)) * kernel_time_per_frame(lattice);
      const int c = lattice.coset(m);
      if (t * t >= 4) continue;
      const bool first = layers[c] == 0;
      layers[c] += std::exp(-2 * t * t);
      const Int3 dims = lattice.space.dims(c);
      for (int z = 0; z < dims[2]; ++z)
        for (int y = 0; y < dims[1]; ++y)
          for (int x = 0; x < dims[0]; ++x) {
            const Vec3 p = lattice.site_position(c, {x, y, z});
            double r2 = 0;
            for (size_t a = 0; a < 3; ++a) r2 += std::pow((q[a] - p[a]) / unit[a], 2);
            if (first && r2 < 12) space += std::exp(-2 * r2);
            if (r2 < 4)
              sums[c] += std::exp(-2 * (r2 + t * t)) * waves({p[0], p[1], p[2], lattice.layer_frame(m)});
          }
    }
    const double r = 2 * std::numbers::sqrt2,
                 within = std::erf(r) - 2 * std::numbers::inv_sqrtpi * r * std::exp(-r * r);
    return (sums[0] / layers[0] + sums[1] / layers[1]) / (space * within);
  };
  size_t compared = 0;
  double most = 0;
  for (int k = 0; k < 2; ++k) {
    const Int3 dims = s.coset[k].dims();
    for (int z = 1; z < dims[2]; z += 5)
      for (int y = 2; y < dims[1]; y += 5)
        for (int x = 3; x < dims[0]; x += 5) {
          const Vec4 q = index_point(s, s.lattice_to_slice.point(s.site(k, {x, y, z})));
          bool inside = true;
          for (size_t i = 0; i < 4; ++i) inside = inside && q[i] > 3.5 && q[i] < lattice.dims[i] - 4.5;
          if (!inside) continue;
          most = larger(most, std::fabs(s.base + s.coset[k].value(x, y, z) - mean_at(q)));
          ++compared;
        }
  }
  EXPECT_GT(compared, 60u);
  EXPECT_LT(most, 1e-4);
}

TEST_F(PlaneSlice, ObliqueWithinFourDecibelsOfTheVolume) {
  const double best = evaluate_snr();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    const Vec4 n{normal(random), normal(random), normal(random), normal(random)};
    EXPECT_GE(slice_snr(cut(through(n, {15.5, 16, 15, 15.7})), lattice, waves, 9, context.get()), best - 4)
        << "plane " << k;
  }
}

TEST_F(PlaneSlice, AxisSlicesWithinOneDecibel) {
  const double best = evaluate_snr();
  for (size_t axis = 0; axis < 3; ++axis) {
    Vec4 n{};
    n[axis] = -2; // any length and sign
    const Slice s = cut(through(n, {14.3, 16.1, 15.9, 0}));
    EXPECT_GE(slice_snr(s, lattice, waves, 9, context.get()), best - 1) << "axis " << axis;
    for (size_t k = 0; k < 3; ++k) // coordinates of the slice are those of the remaining axes
      EXPECT_NEAR(s.basis[k][k < axis ? k : k + 1], 1, 1e-12);
    EXPECT_NEAR(s.origin[axis], (std::array{14.3, 16.1, 15.9})[axis], 1e-12);
  }
}

// The same waves in lattice units, on a lattice of distances that differ.
class StretchedSlice : public testing::Test {
 protected:
  static constexpr LatticeScales asked{1, 0.7, 0.85, 2.3};
  TestContext context;
  Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {33, 25, 29, 70}, asked);
  test::Field4 field = test::in_lattice_units(lattice, PlaneWaves{12, 0.5, 3});
  MemorySamples samples = sample_field(lattice, field);
  Coefficients coefficients{samples, 0, make_kernel("default"), 0, large_cache};
  const Vec4 middle{15.7, 12.1, 14.2, 34.6};

  double snr(const HypersliceOptions& o, const Hyperplane& h, double margin) {
    return slice_snr(hyperslice(coefficients, h, o, {}, context.get()), lattice, field, margin,
                     context.get());
  }
};

TEST_F(StretchedSlice, TimeAndAxisSlicesAreAsAccurateAsOnEqualDistances) {
  for (size_t axis = 0; axis < 4; ++axis) {
    Vec4 n{};
    n[axis] = 1;
    EXPECT_GE(snr({}, through(n, middle), 8), 50) << axis;
  }
}

TEST_F(StretchedSlice, ObliqueOnesHoldWhatTheFinestAxisHolds) {
  for (const Vec4& n :
       {Vec4{0, 1, 1, 0.5}, {1, 1, -1, 0.3}, {0.2, 0.3, 1, -1}, {1, 0, 0, 1}, {0.1, 1, 0.1, 0}})
    EXPECT_GE(snr({}, through(n, middle), 8), 46.5) << n[0] << n[1] << n[2] << n[3];
}

TEST_F(StretchedSlice, MeansAlongANormalConverge) {
  HypersliceOptions thick;
  thick.thickness = {4, ThicknessKind::mean};
  for (const Vec4& n : {Vec4{0, 1, 0, 0}, {0, 0, 0, 1}, {0, 0.8, 0.6, 0}}) {
    const Hyperplane h = through(n, middle);
    const test::Field4 mean = [&](const Vec4& p) {
      constexpr int parts = 64;
      double sum = 0;
      for (int k = 0; k < parts; ++k) {
        Vec4 q = p;
        for (size_t i = 0; i < 4; ++i) q[i] += n[i] * 4 * ((k + 0.5) / parts - 0.5);
        sum += field(q);
      }
      return sum / parts;
    };
    EXPECT_GE(
        slice_snr(hyperslice(coefficients, h, thick, {}, context.get()), lattice, mean, 8, context.get()),
        45);
  }
}

TEST_F(PlaneSlice, EveryTargetLattice) {
  const double best = evaluate_snr();
  const auto snr = [&](const HypersliceOptions& o, const Hyperplane& h) {
    const Slice s = hyperslice(coefficients, h, o, {}, context.get());
    if (o.target) {
      EXPECT_EQ(s.lattice.bcc, *o.target == LatticeKind::bcc);
    }
    return slice_snr(s, lattice, waves, 9, context.get());
  };
  HypersliceOptions cc, dense;
  cc.target = LatticeKind::cc;
  dense.spacing = 0.7;
  for (const Hyperplane& h : {Hyperplane{0, 0, 0, 1, -14.4}, through({0, 1, 0, 0}, {0, 14.4, 0, 0}),
                              through({1, 2, -1, 2}, {15.5, 16, 15, 15.7})}) {
    EXPECT_GE(snr(cc, h), best - 3);
    EXPECT_GE(snr(dense, h), best - 1.5);
  }
}

// A slice at three times the distance holds what its lattice can, and nothing of what is beyond it: of two
// waves along the hyperplane one at a third of its Nyquist rate is there, one at twice the rate is not.
// Points of the coarser lattice would show the second as one of the first's length.
TEST_F(PlaneSlice, CoarserIsLowPassed) {
  for (const Hyperplane& h : {Hyperplane{0, 0, 0, 1, -14.4}, through({0, 1, 0, 0}, {0, 14.4, 0, 0}),
                              through({1, 2, -1, 2}, {15.5, 16, 15, 15.7})}) {
    const auto basis = plane_axes(h).basis;
    const auto wave = [](const Vec4& direction, double part) {
      return [=](const Vec4& p) { return std::cos(part * std::numbers::pi / 3 * dot4(direction, p) + 0.4); };
    };
    const test::Field4 low = wave(basis[0], 1.0 / 3), high = wave(basis[1], 2);
    const auto both = sample_field(lattice, [&](const Vec4& p) { return low(p) + high(p); });
    const Coefficients of_both{both, 0, make_kernel("default"), 0, large_cache};
    for (const LatticeKind kind : {LatticeKind::bcc, LatticeKind::cc}) {
      HypersliceOptions coarse;
      coarse.spacing = 3, coarse.target = kind;
      const Slice s = hyperslice(of_both, h, coarse, {}, context.get());
      EXPECT_LT(s.sites(), cut(h).sites() / 4);
      EXPECT_GE(slice_snr(s, lattice, low, 9, context.get()), 26);
    }
  }
  const auto constant = sample_field(lattice, [](const Vec4&) { return 5.0; });
  const Coefficients of_constant{constant, 0, make_kernel("default"), 0, large_cache};
  HypersliceOptions coarse;
  coarse.spacing = 2.5;
  const Slice s = hyperslice(of_constant, through({1, 0, 0, 1}, {16, 16, 16, 16}), coarse, {}, context.get());
  EXPECT_GE(slice_snr(
                s, lattice, [](const Vec4&) { return 5.0; }, 1, context.get()),
            45);
}

// Equation (6) with a bandwidth for each axis, summed the slow way at sites of a coarser lattice.
TEST_F(PlaneSlice, BandwidthsAreThoseOfTheEquation) {
  const Coefficients paper{samples, 0, make_kernel("paper"), 0, large_cache};
  const Vec3 unit = lattice.lattice_unit();
  const Vec4 width{1.5, 2, 1, 2.5},
      scale{1 / unit[0], 1 / unit[1], 1 / unit[2], lattice.layer_distance() / lattice.time_step};
  HypersliceOptions options;
  options.spacing = 2, options.bandwidth = width;
  for (const Hyperplane& h :
       {Hyperplane{0, 0, 0, 1, -14.4}, through({1, 0.5, -0.3, 0.8}, {16, 15, 16, 17})}) {
    const Slice s = hyperslice(paper, h, options, {}, context.get());
    size_t compared = 0;
    double most = 0;
    const Int3 dims = s.coset[0].dims();
    for (int z = 1; z < dims[2]; z += 3)
      for (int y = 2; y < dims[1]; y += 3)
        for (int x = 1; x < dims[0]; x += 3) {
          const Vec4 q = index_point(s, s.lattice_to_slice.point(s.site(0, {x, y, z})));
          bool inside = true;
          for (size_t i = 0; i < 4; ++i) inside = inside && q[i] > 6 && q[i] < lattice.dims[i] - 7.0;
          if (!inside) continue;
          double sum = 0, weights = 0;
          for (int32_t m = 0; m < lattice.layers(); ++m) {
            const int c = lattice.coset(m);
            const double t = (q[3] - lattice.layer_frame(m)) * scale[3] / width[3];
            if (t * t >= 4) continue;
            const Int3 n = lattice.space.dims(c);
            for (int k = 0; k < n[2]; ++k)
              for (int j = 0; j < n[1]; ++j)
                for (int i = 0; i < n[0]; ++i) {
                  const Vec3 p = lattice.site_position(c, {i, j, k});
                  double r2 = t * t;
                  for (size_t a = 0; a < 3; ++a) r2 += std::pow((q[a] - p[a]) * scale[a] / width[a], 2);
                  if (r2 >= 4) continue;
                  const double w = std::exp(-2 * r2);
                  sum += w * waves({p[0], p[1], p[2], lattice.layer_frame(m)}), weights += w;
                }
          }
          most = larger(most, std::fabs(s.base + s.coset[0].value(x, y, z) - sum / weights));
          ++compared;
        }
    EXPECT_GE(compared, 8u);
    EXPECT_LT(most, 1e-4);
  }
  EXPECT_THROW((void)hyperslice(coefficients, {0, 0, 0, 1, -14.4}, options, {}, context.get()), Error);
  options.method = SliceMethod::merged;
  EXPECT_THROW((void)hyperslice(paper, {0, 0, 0, 1, -14.4}, options, {}, context.get()), Error);
}

TEST_F(PlaneSlice, PointAndBasis) {
  const Vec4 point{15, 16.5, 14, 15.2};
  const std::array<Vec4, 3> directions{Vec4{2, 0, 0, 1}, Vec4{1, 1, 0, 0}, Vec4{0, 0.5, 3, -1}};
  HypersliceOptions o;
  o.axes = plane_axes(point, directions);
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) EXPECT_NEAR(dot4(o.axes->basis[i], o.axes->basis[j]), i == j, 1e-14);
    EXPECT_GT(dot4(o.axes->basis[i], directions[i]), 0);
  }
  const Hyperplane h = hyperplane_of(*o.axes);
  EXPECT_NEAR(h[0] * h[0] + h[1] * h[1] + h[2] * h[2] + h[3] * h[3], 1, 1e-14);
  for (const Vec4& d : directions) {
    Vec4 p = point;
    for (size_t i = 0; i < 4; ++i) p[i] += 2.5 * d[i];
    EXPECT_NEAR(height(h, p), 0, 1e-12);
  }
  const Slice s = hyperslice(coefficients, h, o, {}, context.get());
  EXPECT_EQ(s.origin, point);
  EXPECT_GE(slice_snr(s, lattice, waves, 9, context.get()), evaluate_snr() - 3);
  // Directions within a time slice turn its lattice, and the field is the same.
  o.axes = plane_axes({15, 15, 15, 15.2}, {Vec4{1, 1, 0, 0}, Vec4{-1, 1, 0, 0}, Vec4{0, 0, 1, 0}});
  EXPECT_GE(slice_snr(hyperslice(coefficients, hyperplane_of(*o.axes), o, {}, context.get()), lattice, waves,
                      9, context.get()),
            evaluate_snr() - 3);
  EXPECT_THROW((void)plane_axes(point, {directions[0], directions[1], directions[0]}), Error);
  EXPECT_THROW((void)plane_axes(point, {directions[0], directions[1], Vec4{}}), Error);
  EXPECT_THROW((void)plane_axes({std::nan(""), 0, 0, 0}, directions), Error);
}

TEST_F(PlaneSlice, ConstantFieldIsConstant) {
  const auto flat = sample_field(lattice, [](const Vec4&) { return 4.0; });
  const Coefficients c(flat, 0, make_kernel("default"), 0, large_cache);
  const Slice s = hyperslice(c, through({1, 2, -1, 3}, {15, 15, 15, 15}), {}, {}, context.get());
  std::vector<float> v(30 * 30 * 30);
  Grid grid;
  for (size_t a = 0; a < 3; ++a) {
    const double unit = s.lattice_to_slice.linear[a][a];
    grid.origin[a] = s.lattice_to_slice.offset[a] + s.domain_begin[a] * unit;
    grid.dims[a] = 30;
    grid.step[a] = (s.domain_end[a] - s.domain_begin[a]) * unit / 29;
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
  const auto check = [&](const Slice& s) {
    EXPECT_TRUE(s.empty());
    EXPECT_EQ(s.points(), 0);
    EXPECT_EQ(list_points(s, 0, nullptr, nullptr, context.get().progress), 0u);
    Grid grid; // around every point that the slice could have
    grid.origin = {-5, -5, -5}, grid.dims = {11, 11, 11};
    std::vector<float> v(11 * 11 * 11);
    sample_grid(s, grid, v.data(), context.get());
    for (const float x : v) ASSERT_TRUE(std::isnan(x));
    const std::vector<Vec3> point{{0, 0, 0}};
    EXPECT_EQ(sample_points(s, point, std::span(v).first(1), {}, context.get()).outside, 1u);
    EXPECT_TRUE(std::isnan(v[0]));
  };
  for (size_t axis = 0; axis < 3; ++axis)
    for (const double at : {-3.0, -1e-3, 31.001, 40.0}) check(cut(across(axis, at)));
  check(cut(through({1, 1, 1, 1}, {31.0001, 31, 31, 31})));
  EXPECT_FALSE(cut({1, 0, 0, 0, -31}).empty()); // the faces belong to the domain
  EXPECT_FALSE(cut({1, 0, 0, 0, 0}).empty());
}

TEST_F(PlaneSlice, AxisSlicesAreTimeSlicesOfTheTurnedField) {
  // The two agree bit for bit, on both lattices, whatever the axis; also near the ends, where planes are
  // mirrored.
  const std::array<uint32_t, 4> dims{19, 17, 21, 14};
  const PlaneWaves f(6, 0.6, 71);
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto straight = Lattice4::fit(kind, dims);
      std::array<size_t, 4> axes{0, 1, 2, 3};
      std::rotate(axes.begin() + axis, axes.begin() + axis + 1, axes.end());
      Lattice4 turned = straight; // the same sites with the axis last
      for (size_t a = 0; a < 3; ++a) {
        turned.dims[a] = dims[axes[a]];
        turned.space.last[a] = axes[a] == 3 ? straight.last_layer : straight.space.last[axes[a]];
        turned.space_step[a] = axes[a] == 3 ? straight.time_step : straight.space_step[axes[a]];
      }
      turned.dims[3] = dims[axis];
      turned.last_layer = straight.space.last[axis], turned.time_step = straight.space_step[axis];
      const auto source = sample_field(straight, f);
      const auto other = sample_field(turned, [&](const Vec4& p) {
        Vec4 q;
        for (size_t a = 0; a < 4; ++a) q[axes[a]] = p[a];
        return f(q);
      });
      const Coefficients c(source, 0, make_kernel("default"), 0, large_cache);
      const Coefficients d(other, 0, make_kernel("default"), 0, large_cache);
      for (const double at : {0.0, 0.4, 8.3, dims[axis] - 1.2, dims[axis] - 1.0}) {
        const Slice a = hyperslice(c, across(axis, at), {}, {}, context.get());
        const Slice b = time_slice(d, at, {0, 0}, {}, context.get());
        for (size_t k = 0; k < static_cast<size_t>(a.lattice.cosets()); ++k)
          ASSERT_EQ(layer_to_dense(a.coset[k]), layer_to_dense(b.coset[k])) << axis << " at " << at;
        ASSERT_EQ(a.domain_end, b.domain_end);
      }
    }
}

TEST_F(PlaneSlice, AxisSlicesKeepHoles) {
  const auto small = Lattice4::fit(LatticeKind::d4star, {12, 12, 12, 12});
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < small.layers(); ++m) {
    BrickLayer layer(small.space, small.coset(m));
    auto brick = std::make_shared<Brick>();
    brick->value[0] = 1, brick->kept[0] = 1;
    if (m == 6) { // site (3, 4, 5) of coset 0
      brick->hole = std::make_unique<BrickMask>();
      (*brick->hole)[5 * brick_edge + 4] = 1 << 3;
    }
    layer.set(0, std::move(brick));
    layers.push_back(std::move(layer));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  const MemorySamples holes(small, {0}, std::move(channels));
  const Coefficients c(holes, 0, make_kernel("default"), 0, large_cache);
  const Vec3 p = small.site_position(0, {3, 4, 5});
  const double t = small.layer_frame(6);
  for (size_t axis = 0; axis < 3; ++axis) {
    const Slice s = hyperslice(c, across(axis, p[axis]), {}, {}, context.get());
    EXPECT_TRUE(s.has_holes);
    Vec3 at{p[axis == 0 ? 1 : 0], p[axis == 2 ? 1 : 2], t}, beside = at;
    beside[2] += 1.5;
    std::vector<float> v(2);
    EXPECT_EQ(sample_points(s, std::vector{at, beside}, v, {}, context.get()).holes, 1u) << axis;
    EXPECT_TRUE(std::isnan(v[0]) && !std::isnan(v[1])) << axis;
  }
}

// A source that counts what is read of it, and spoils what is not.
struct Watching final : SampleSource {
  const MemorySamples& inner;
  mutable std::set<std::pair<int32_t, size_t>> seen; // layer, slot
  explicit Watching(const MemorySamples& s) : inner(s) {}
  const Lattice4& lattice() const override { return inner.lattice(); }
  int channels() const override { return 1; }
  float air(int c) const override { return inner.air(c); }
  BrickLayer read_layer(int c, int32_t layer, const BrickBox& region, const Context& ctx) const override {
    const BrickLayer whole = inner.read_layer(c, layer, region, ctx);
    BrickLayer part(whole.lattice(), whole.coset());
    for (size_t s = 0; s < whole.brick_slots(); ++s)
      if (region.contains(whole.slot_position(s))) part.set(s, whole.share(s)), seen.insert({layer, s});
    return part;
  }
  [[nodiscard]] double fraction() const {
    size_t all = 0;
    for (int32_t m = 0; m < lattice().layers(); ++m)
      all += BrickLayer(lattice().space, lattice().coset(m)).brick_slots();
    return static_cast<double>(seen.size()) / static_cast<double>(all);
  }
};

TEST_F(PlaneSlice, ReadsOnlyTheBricksItTouches) {
  const auto large = Lattice4::fit(LatticeKind::d4star, {96, 70, 24, 60});
  const auto field = sample_field(large, PlaneWaves(6, 0.5, 13));
  const Coefficients whole(field, 0, make_kernel("default"), 0, large_cache);
  const struct {
    Hyperplane h;
    double most;                                              // of all bricks
  } cases[] = {{{1, 0, 0, 0, -50.2}, 0.41},                   // 2 bricks of 5
               {through({1, 0, 0, 1}, {48, 0, 0, 30}), 0.55}, // moves with time
               {through({2, 1, 0.3, 2}, {48, 35, 12, 30}), 0.65}};
  for (const auto& [h, most] : cases) {
    const Watching source(field);
    const Coefficients partial(source, 0, make_kernel("default"), 0, large_cache);
    const Slice s = hyperslice(partial, h, {}, {}, context.get());
    EXPECT_LT(source.fraction(), most);
    std::vector<Vec4> points;
    std::vector<Vec3> uvw;
    std::mt19937 random(17);
    while (points.size() < 500) {
      Vec3 p;
      for (size_t a = 0; a < 3; ++a)
        p[a] = std::uniform_real_distribution<double>(0, s.domain_end[a])(random);
      if (!s.inside(p)) continue;
      uvw.push_back(s.lattice_to_slice.point(p));
      points.push_back(index_point(s, uvw.back()));
      for (size_t a = 0; a < 4; ++a) // rounding at the faces
        points.back()[a] = std::clamp(points.back()[a], 0.0, large.dims[a] - 1.0);
    }
    std::vector<float> got(points.size()), wanted(points.size());
    sample_points(s, uvw, got, {}, context.get());
    evaluate4(whole, points, wanted, {}, context.get());
    double error = 0;
    for (size_t i = 0; i < points.size(); ++i) error += std::pow(got[i] - wanted[i], 2);
    // Plane waves do not mirror at the faces, so both reconstructions are rough there, but equally so.
    EXPECT_LT(std::sqrt(error / static_cast<double>(points.size())), 0.1);
  }
}

TEST_F(PlaneSlice, BricksThatAreNotReadDoNotMatter) {
  // The same slice from a volume whose other bricks hold something else.
  const auto large = Lattice4::fit(LatticeKind::d4star, {96, 40, 24, 40});
  const Hyperplane h = through({1, 0.2, 0.1, 1}, {48, 20, 12, 20});
  const auto field = sample_field(large, PlaneWaves(6, 0.5, 13));
  const Watching watch(field);
  const Slice a =
      hyperslice(Coefficients(watch, 0, make_kernel("default"), 0, large_cache), h, {}, {}, context.get());
  std::vector<std::vector<BrickLayer>> channels(1);
  auto junk = std::make_shared<Brick>();
  junk->value.fill(1e6);
  junk->kept.fill(0xffff);
  for (int32_t m = 0; m < large.layers(); ++m) {
    BrickLayer layer = field.read_layer(0, m, {}, context.get());
    for (size_t s = 0; s < layer.brick_slots(); ++s)
      if (!watch.seen.contains({m, s})) layer.set(s, junk);
    channels[0].push_back(std::move(layer));
  }
  ASSERT_LT(watch.fraction(), 0.6);
  // Now with the whole volume in view: no region is cut, all bricks are there for the asking.
  const MemorySamples spoiled(large, {0}, std::move(channels));
  const Coefficients all(spoiled, 0, make_kernel("default"), 0, large_cache);
  const Coefficients clean(field, 0, make_kernel("default"), 0, large_cache);
  std::vector<Vec4> points;
  std::mt19937 random(19);
  while (points.size() < 500) {
    Vec3 p;
    for (size_t k = 0; k < 3; ++k) p[k] = std::uniform_real_distribution<double>(0, a.domain_end[k])(random);
    if (!a.inside(p)) continue;
    points.push_back(index_point(a, a.lattice_to_slice.point(p)));
    for (size_t k = 0; k < 4; ++k) points.back()[k] = std::clamp(points.back()[k], 0.0, large.dims[k] - 1.0);
  }
  std::vector<float> v(points.size()), w(points.size());
  evaluate4(all, points, v, {}, context.get());
  evaluate4(clean, points, w, {}, context.get());
  EXPECT_EQ(v, w);
}

TEST_F(PlaneSlice, ThreadsDoNotChangeABit) {
  TestContext one(1), four(4);
  for (const Hyperplane& h : {Hyperplane{0, 0, 1, 0, -12.3}, through({1, 2, -1, 2}, {15.5, 16, 15, 15.7})})
    for (const ThicknessKind kind : {ThicknessKind::mean, ThicknessKind::maximum}) {
      HypersliceOptions o;
      o.thickness = {2, kind};
      const Slice a = hyperslice({samples, 0, make_kernel("fast"), 0, large_cache}, h, o, {}, one.get());
      const Slice b = hyperslice({samples, 0, make_kernel("fast"), 0, large_cache}, h, o, {}, four.get());
      for (size_t c = 0; c < 2; ++c) EXPECT_EQ(layer_to_dense(a.coset[c]), layer_to_dense(b.coset[c]));
    }
}

TEST_F(PlaneSlice, BudgetIsKept) {
  for (const Hyperplane& h : {Hyperplane{0, 0, 1, 0, -12.3}, through({1, 2, -1, 2}, {15.5, 16, 15, 15.7})}) {
    TestContext small(2, 200'000);
    try {
      (void)hyperslice(coefficients, h, {}, {}, small.get());
      ADD_FAILURE() << "a budget smaller than the planes was accepted";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::memory_budget);
    }
    EXPECT_LE(small.memory.peak(), 200'000u);
    EXPECT_EQ(small.memory.used(), 0u);
  }
}

TEST_F(PlaneSlice, WorldKeepsLengthsAndAngles) {
  Affine3 world; // anisotropic and sheared
  world.linear = {Vec3{2, 0.5, 0}, Vec3{0, 3, 0}, Vec3{0, 0, 0.7}};
  HypersliceOptions options;
  options.time_length = 5;
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

// A slice's place: that of its points in space, along the axes of the world that lie in it.
TEST_F(PlaneSlice, StandsInTheWorldOfItsVolume) {
  Affine3 world; // x to the left, y and z exchanged, far from the origin
  world.linear = {Vec3{-2, 0, 0}, Vec3{0, 0, 0.7}, Vec3{0, -3, 0}};
  world.offset = {100, -50, 7};
  HypersliceOptions options;
  options.time_length = 5;
  const Vec3 p{3, 4, 6};
  const auto place = [&](const Hyperplane& h) {
    return world_affine(plane_axes(h), world, options.time_length).point(p);
  };
  const auto near = [](const Vec3& a, const Vec3& b) { return length(a - b) < 1e-12; };
  EXPECT_TRUE(near(place({0, 0, 0, 1, -8}), world.point(p))); // u, v, w: x, y, z
  const Vec3 x = world.point({9, p[0], p[1]});                // y, z, t
  EXPECT_TRUE(near(place(across(0, 9)), {x[1], x[2], 5 * p[2]}));
  const Vec3 y = world.point({p[0], 9, p[1]}); // along the world's z, which is left out
  EXPECT_TRUE(near(place(across(1, 9)), {y[0], y[1], 5 * p[2]}));
  const Vec3 z = world.point({p[0], p[1], 9});
  EXPECT_TRUE(near(place(across(2, 9)), {z[0], z[2], 5 * p[2]}));
  // Slices have it, however they are made and whatever axes they are asked for along.
  const Hyperplane h = through({1, 0.3, -0.2, 0.5}, {15, 15, 15, 15});
  const Slice usual = plane_slice(coefficients, h, options, world, context.get());
  options.axes = PlaneAxes{index_point(usual, {1, 2, 3}), {usual.basis[2], usual.basis[0], usual.basis[1]}};
  const Slice turned = plane_slice(coefficients, h, options, world, context.get());
  EXPECT_LT(length(usual.slice_to_world.point({1, 2, 3}) - turned.slice_to_world.point({0, 0, 0})), 1e-9);
  EXPECT_LT(length(usual.slice_to_world.point({5, 7, 4}) - turned.slice_to_world.point({1, 4, 5})), 1e-9);
  HypersliceOptions merged;
  merged.time_length = 5;
  const Slice axis = hyperslice(coefficients, across(0, 9), merged, world, context.get());
  EXPECT_TRUE(near(axis.slice_to_world.point(p), {x[1], x[2], 5 * p[2]}));
}

} // namespace
} // namespace bccsplat
