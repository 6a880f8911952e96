// SPDX-License-Identifier: Apache-2.0
// Points of a caller to points of the inner loop, on every instruction set against a reference.
#include "field/point_axes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/targets.h"

namespace bccsplat {
namespace {

constexpr double nan_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// Inside, on the ends, beyond them, and not numbers; as many as fill no vector.
std::vector<Vec4> points_around(const std::array<uint32_t, 4>& dims) {
  std::vector<Vec4> points;
  std::mt19937 random(4);
  for (int n = 0; n < 77; ++n) {
    Vec4 p;
    for (size_t a = 0; a < 4; ++a)
      p[a] = std::uniform_real_distribution<double>(-0.02, 1.02)(random) * (dims[a] - 1.0);
    if (n % 7 == 0) p[static_cast<size_t>(n) / 7 % 4] = dims[static_cast<size_t>(n) / 7 % 4] - 1.0;
    if (n % 11 == 0) p[static_cast<size_t>(n) / 11 % 4] = n % 2 == 0 ? nan_number : infinity;
    points.push_back(p);
  }
  return points;
}

TEST(PointAxes, MatchesTheReferenceOnEveryTarget) {
  for (const std::array<uint32_t, 4>& dims : {std::array<uint32_t, 4>{60, 47, 33, 12}, {60, 47, 33, 1}}) {
    const Lattice4 lattice = Lattice4::fit(dims[3] > 1 ? LatticeKind::d4star : LatticeKind::bcc, dims);
    ASSERT_EQ(lattice.is_static(), dims[3] == 1);
    const std::vector<Vec4> points = points_around(dims);
    const PointAxes axes(lattice, points.size());
    std::vector<uint64_t> at(points.size());
    for (size_t n = 0; n < at.size(); ++n) at[n] = at.size() - 1 - n;
    test::for_targets([&] {
      std::vector<PointPlace> places(points.size());
      axes.place(points, true, places);
      for (size_t n = 0; n < points.size(); ++n) {
        Vec4 p = points[n];
        for (size_t a = 0; a < 4; ++a) p[a] = std::max(p[a] < axes.end[a] ? p[a] : axes.end[a], 0.0);
        std::array<int32_t, 3> cell;
        for (size_t a = 0; a < 3; ++a) cell[a] = static_cast<int32_t>(p[a] * axes.per_cell[a]);
        const int32_t expected = (cell[2] * axes.cells[1] + cell[1]) * axes.cells[0] + cell[0];
        EXPECT_EQ(places[n].cell, static_cast<uint32_t>(expected)) << n;
        EXPECT_LT(places[n].cell, axes.cell_count);
        const double layers = lattice.is_static() ? 0 : std::floor(p[3] * axes.per_layer);
        EXPECT_EQ(places[n].window, static_cast<int32_t>(layers)) << n;
      }
      for (const bool clip : {true, false}) {
        std::vector<Vec4> scaled(points.size());
        std::vector<uint8_t> outside(points.size(), 7);
        size_t misses = 0;
        const size_t told = axes.scale_points(points.data(), at, clip, scaled.data(), outside.data());
        for (size_t n = 0; n < points.size(); ++n) {
          const Vec4& p = points[at[n]];
          bool in = true;
          for (size_t a = 0; a < (lattice.is_static() ? 3 : 4); ++a)
            in = in && p[a] >= 0 && p[a] <= dims[a] - 1.0;
          const bool miss = clip && !in;
          misses += miss;
          ASSERT_EQ(outside[n], miss) << n;
          for (size_t a = 0; a < 4; ++a) {
            const double expected = miss ? 0 : p[a] * axes.scale[a];
            if (std::isnan(expected))
              EXPECT_TRUE(std::isnan(scaled[n][a]));
            else
              EXPECT_EQ(scaled[n][a], expected) << n << " axis " << a;
          }
        }
        EXPECT_EQ(told, misses);
      }
    });
  }
}

} // namespace
} // namespace bccsplat
