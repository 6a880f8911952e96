// SPDX-License-Identifier: Apache-2.0
// The inner loop of evaluation: every instruction set against the formula, and whatever shares the batch.
#include "field/footprint/footprint.h"

#include <gtest/gtest.h>

#include <numeric>

#include "field/evaluate.h"
#include "field/point_order.h"
#include "field/slice.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using test::for_targets;
using test::TestContext;

// Layers of noise in [-1, 1] on a lattice whose cosets span two bricks along x, one and two along y and z; a
// brick in four is absent.
struct Noise {
  Lattice3 lattice;
  std::vector<BrickLayer> layers;
  std::vector<FieldLayer> field;

  explicit Noise(int count, const Int3& last = {44, 21, 37}) {
    lattice.last = last;
    std::mt19937 random(static_cast<uint32_t>(7 + count));
    std::uniform_real_distribution<float> value(-1, 1);
    for (int m = 0; m < count; ++m) {
      std::vector<float> dense(static_cast<size_t>(lattice.sites(m & 1)));
      for (float& v : dense) v = value(random);
      layers.push_back(test::layer_from_dense(lattice, m & 1, dense));
      for (size_t s = 0; s < layers.back().brick_slots(); ++s)
        if (random() % 4 == 0) layers.back().set(s, nullptr);
    }
    for (int m = 0; m < count; ++m) field.push_back({&layers[m], m / std::numbers::sqrt2});
  }
  [[nodiscard]] Vec3 end() const {
    const double d = lattice.plane_distance();
    return {d * lattice.last[0], d * lattice.last[1], d * lattice.last[2]};
  }
};

// The formula itself: every site of every layer in reach, in double.
struct Truth {
  double value = 0;
  std::array<double, 4> slope{};
};
Truth footprint_reference(const Noise& noise, const Kernel& kernel, const Vec4& p) {
  Truth truth;
  std::array<double, 2> weight_sum{}, slope_sum{};
  std::array<Truth, 2> coset;
  for (const FieldLayer& l : noise.field) {
    const int c = l.layer->coset();
    const size_t i = c;
    const double w = kernel.time.value(p[3] - l.time), dw = kernel.time.slope(p[3] - l.time);
    weight_sum[i] += w, slope_sum[i] += dw;
    if (w == 0 && dw == 0) continue;
    Int3 at;
    const auto near = [&](size_t a) { return static_cast<int32_t>(std::floor(p[a] / std::numbers::sqrt2)); };
    for (at[2] = near(2) - 3; at[2] < near(2) + 4; ++at[2])
      for (at[1] = near(1) - 3; at[1] < near(1) + 4; ++at[1])
        for (at[0] = near(0) - 3; at[0] < near(0) + 4; ++at[0]) {
          Vec3 v;
          Int3 site;
          for (size_t a = 0; a < 3; ++a) {
            v[a] = p[a] - noise.lattice.plane_distance() * noise.lattice.plane(c, at[a]);
            site[a] = noise.lattice.mirror(a, c, at[a]);
          }
          const double coefficient = l.layer->value(site[0], site[1], site[2]);
          const double phi = kernel.space.value(dot(v, v));
          coset[i].value += coefficient * w * phi;
          coset[i].slope[3] += coefficient * dw * phi;
          for (size_t a = 0; a < 3; ++a)
            coset[i].slope[a] += coefficient * w * 2 * v[a] * kernel.space.slope(dot(v, v));
        }
  }
  for (size_t i = 0; i < 2; ++i) {
    if (kernel.normalised && weight_sum[i] > 0) {
      coset[i].slope[3] -= coset[i].value * slope_sum[i] / weight_sum[i];
      coset[i].value /= weight_sum[i];
      for (double& s : coset[i].slope) s /= weight_sum[i];
    }
    truth.value += coset[i].value;
    for (size_t a = 0; a < 4; ++a) truth.slope[a] += coset[i].slope[a];
  }
  if (!kernel.normalised) return truth;
  const double total = lattice_sum(kernel, p[0], p[1], p[2]);
  truth.value /= total;
  for (size_t a = 0; a < 4; ++a) {
    Vec3 low{p[0], p[1], p[2]}, high = low;
    double slope = 0;
    if (a < 3) {
      low[a] -= 1e-5, high[a] += 1e-5;
      slope = (lattice_sum(kernel, high[0], high[1], high[2]) - lattice_sum(kernel, low[0], low[1], low[2])) /
              2e-5;
    }
    truth.slope[a] = (truth.slope[a] - truth.value * slope) / total;
  }
  return truth;
}

// Points close together: `count` of them in cubes of edge `size`; time the same within a cube when `still`.
std::vector<Vec4> clustered(const Noise& noise, size_t cubes, size_t count, double size, bool still) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec4> points;
  for (size_t k = 0; k < cubes; ++k) {
    Vec3 corner;
    for (size_t a = 0; a < 3; ++a) corner[a] = unit(random) * (noise.end()[a] - size);
    const double time = 3.1 + 0.4 * unit(random);
    for (size_t i = 0; i < count; ++i)
      points.push_back({corner[0] + size * unit(random), corner[1] + size * unit(random),
                        corner[2] + size * unit(random), still ? time : 3.1 + 0.4 * unit(random)});
  }
  return points;
}

class FootprintKernel : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Footprint, FootprintKernel,
                         testing::Values("fast", "default", "fine", "gauss09", "paper", "radial18+b2"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), '+', '_');
                           return name;
                         });

TEST_P(FootprintKernel, SumsAreTheFormulaOnEveryTarget) {
  const Kernel kernel = make_kernel(GetParam());
  const Noise noise(10);
  struct Case {
    std::vector<Vec4> points;
    const char* name;
  };
  std::vector<Case> cases;
  cases.push_back({clustered(noise, 1, 300, 15, false), "scattered"});
  cases.push_back({clustered(noise, 2, 256, 4, false), "together"});
  cases.push_back({clustered(noise, 2, 256, 4, true), "together at one time"});
  // At the very corners a cut Gaussian's edge, where it jumps, passes through sites.
  const double in = kernel.time.shape == TemporalKernel::Shape::gaussian ? 0.01 : 0;
  const Vec3 end = noise.end();
  cases.push_back({{{in, in, in, 3.2}, {end[0] - in, end[1] - in, end[2] - in, 3.2}}, "corners"});
  for_targets([&] {
    for (const Case& c : cases) {
      SCOPED_TRACE(c.name);
      std::vector<float> values(c.points.size()), alone(c.points.size());
      std::vector<std::array<float, 4>> slopes(c.points.size());
      const FieldLayers field{noise.field, &kernel, false};
      sum_footprints(field, c.points, values.data(), slopes.data());
      sum_footprints(field, c.points, alone.data(), nullptr);
      for (size_t n = 0; n < c.points.size(); ++n) {
        const Truth truth = footprint_reference(noise, kernel, c.points[n]);
        ASSERT_NEAR(values[n], truth.value, 3e-6) << n;
        ASSERT_EQ(values[n], alone[n]) << n;
        for (size_t a = 0; a < 4; ++a) ASSERT_NEAR(slopes[n][a], truth.slope[a], 2e-5) << n << " axis " << a;
      }
    }
  });
}

TEST_P(FootprintKernel, CompanyInABatchChangesNoBit) {
  const Kernel kernel = make_kernel(GetParam());
  const Noise noise(10);
  const FieldLayers field{noise.field, &kernel, false};
  for (const bool still : {false, true}) {
    const auto points = clustered(noise, 2, 256, 5, still);
    std::vector<float> together(points.size());
    std::vector<std::array<float, 4>> slopes(points.size());
    sum_footprints(field, points, together.data(), slopes.data());
    for (size_t n = 0; n < points.size(); ++n) {
      float value = 0;
      std::array<float, 4> slope{};
      sum_footprints(field, std::span(points).subspan(n, 1), &value, &slope);
      ASSERT_EQ(value, together[n]) << n;
      ASSERT_EQ(slope, slopes[n]) << n;
    }
  }
}

// Paths through a batch are copied each for itself, what lies between them is looked up.
TEST_P(FootprintKernel, PathsInABatchChangeNoBit) {
  const Kernel kernel = make_kernel(GetParam());
  const Noise noise(10);
  const FieldLayers field{noise.field, &kernel, false};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  const Vec3 end = noise.end();
  std::vector<Vec4> points;
  for (const size_t length : {100u, 1u, 3u, 60u, 23u, 1u, 150u}) {
    Vec4 p{end[0] * unit(random), end[1] * unit(random), end[2] * unit(random), 3};
    const bool still = length == 60;
    for (size_t i = 0; i < length; ++i, p[3] += still ? 0 : 0.003) {
      points.push_back(p);
      for (size_t a = 0; a < 3; ++a) p[a] = std::min(p[a] + 0.02, end[a]);
    }
  }
  std::vector<float> together(points.size());
  sum_footprints(field, points, together.data(), nullptr);
  for (size_t n = 0; n < points.size(); ++n) {
    float value = 0;
    sum_footprints(field, std::span(points).subspan(n, 1), &value, nullptr);
    ASSERT_EQ(value, together[n]) << n;
    ASSERT_NEAR(value, footprint_reference(noise, kernel, points[n]).value, 3e-6) << n;
  }
}

TEST(Footprint, TinyLatticesMirrorOnBothSidesAtOnce) {
  for (const Int3& last : {Int3{1, 1, 1}, Int3{2, 1, 3}, Int3{3, 4, 2}}) {
    const Noise noise(10, last);
    const Kernel kernel = make_kernel("fine");
    const FieldLayers field{noise.field, &kernel, false};
    std::vector<Vec4> points;
    for (int i = 0; i < 100; ++i)
      points.push_back({noise.end()[0] * (i % 5) / 4, noise.end()[1] * (i / 5 % 5) / 4,
                        noise.end()[2] * (i / 25) / 3, 3.3});
    std::vector<float> values(points.size());
    sum_footprints(field, points, values.data(), nullptr);
    for (size_t n = 0; n < points.size(); ++n) {
      ASSERT_NEAR(values[n], footprint_reference(noise, kernel, points[n]).value, 3e-6);
      float value = 0;
      sum_footprints(field, std::span(points).subspan(n, 1), &value, nullptr);
      ASSERT_EQ(value, values[n]);
    }
  }
}

TEST(Footprint, AirIsZero) {
  Noise noise(10);
  for (BrickLayer& layer : noise.layers)
    for (size_t s = 0; s < layer.brick_slots(); ++s) layer.set(s, nullptr);
  const Kernel kernel = make_kernel("default");
  const auto points = clustered(noise, 3, 100, 10, false);
  std::vector<float> values(points.size(), 1);
  sum_footprints({noise.field, &kernel, false}, points, values.data(), nullptr);
  for (const float v : values) ASSERT_EQ(v, 0);
}

TEST(PointOrder, GathersByWindowThenCell) {
  TestContext context;
  std::mt19937 random(3);
  for (const uint32_t cells : {1u, 60u}) {
    std::vector<PointPlace> at(20'000);
    for (PointPlace& p : at)
      p = {static_cast<int32_t>(random() % 7) - 3, static_cast<uint32_t>(random() % cells)};
    const auto place = [&](uint64_t begin, std::span<PointPlace> out) {
      std::copy_n(at.begin() + begin, out.size(), out.begin());
    };
    const PointOrder order = order_points(at.size(), cells, place, context.get());
    ASSERT_EQ(order.groups.size(), 7u);
    std::vector<bool> seen(at.size());
    uint64_t next = 0;
    for (const auto& group : order.groups) {
      ASSERT_EQ(group.begin, next);
      next = group.end;
      for (uint64_t n = group.begin; n < group.end; ++n) {
        uint64_t point = 0;
        order.points_at(n, std::span(&point, 1));
        ASSERT_FALSE(seen[point]);
        seen[point] = true;
        ASSERT_EQ(at[point].window, group.window);
        if (n == group.begin) continue;
        uint64_t before = 0;
        order.points_at(n - 1, std::span(&before, 1));
        ASSERT_LE(at[before].cell, at[point].cell);
        if (at[before].cell == at[point].cell) {
          ASSERT_LT(before, point);
        }
      }
    }
    ASSERT_EQ(next, at.size());
  }
}

TEST(PointOrder, LeavesPointsInOrderAlone) {
  TestContext context;
  const auto place = [](uint64_t begin, std::span<PointPlace> out) {
    for (uint64_t i = 0; i < out.size(); ++i) out[i] = {5, static_cast<uint32_t>((begin + i) / 1000)};
  };
  const PointOrder order = order_points(30'000, 30, place, context.get());
  EXPECT_TRUE(order.order.empty());
  ASSERT_EQ(order.groups.size(), 1u);
  EXPECT_EQ(order.groups[0].window, 5);
  EXPECT_TRUE(order.runs.empty());
  uint64_t last = 0;
  order.points_at(29'999, std::span(&last, 1));
  EXPECT_EQ(last, 29'999u);
  EXPECT_TRUE(order_points(0, 1, place, context.get()).groups.empty());
}

// Stretches of one window, and short ones of one cell as well, move as they are.
TEST(PointOrder, MovesRunsAsTheyAre) {
  TestContext context;
  std::mt19937 random(9);
  for (const uint32_t length : {200u, 6u}) {
    std::vector<PointPlace> at;
    while (at.size() < 30'000)
      at.insert(at.end(), length / 2 + random() % length,
                {static_cast<int32_t>(random() % 5) - 2, static_cast<uint32_t>(random() % 9)});
    const auto place = [&](uint64_t begin, std::span<PointPlace> out) {
      std::copy_n(at.begin() + begin, out.size(), out.begin());
    };
    const PointOrder order = order_points(at.size(), 9, place, context.get());
    EXPECT_TRUE(order.order.empty());
    ASSERT_EQ(order.groups.size(), 5u);
    std::vector<uint64_t> all(at.size());
    for (uint64_t n = 0; n < all.size(); n += 500)
      (void)order.points_at(n, std::span(all).subspan(n, std::min<uint64_t>(500, all.size() - n)));
    std::vector<uint64_t> expected(all.size());
    std::iota(expected.begin(), expected.end(), uint64_t{0});
    const auto key = [&](uint64_t n) {
      return std::pair(at[n].window, length == 6 ? at[n].cell : 0); // long runs are worth no search
    };
    std::stable_sort(expected.begin(), expected.end(),
                     [&](uint64_t a, uint64_t b) { return key(a) < key(b); });
    EXPECT_EQ(all, expected);
    for (const auto& group : order.groups)
      for (uint64_t n = group.begin; n < group.end; ++n) ASSERT_EQ(at[all[n]].window, group.window);
  }
}

} // namespace
} // namespace bccsplat
