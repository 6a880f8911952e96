// SPDX-License-Identifier: Apache-2.0
// The points of a slice are compared with its sites, one by one, and every loop with its reference form.
#include "splat/points/points.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <tuple>

#include "splat/points/brick_sites.h"
#include "splat/points/cell_ranges.h"
#include "splat/points/point_sizes.h"
#include "tests/support/dense_layer.h"
#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using namespace test;

// Returns coefficients at random, at `filled` of the sites of a lattice, some of whose boxes are empty
// throughout.
Slice random_slice(bool bcc, const Int3& last, double filled, unsigned seed) {
  Slice slice;
  slice.lattice = {bcc, last};
  slice.kernel = make_kernel("default");
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-3, 3);
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    const Int3 dims = slice.lattice.dims(c);
    std::vector<float> dense(static_cast<size_t>(slice.lattice.sites(c)));
    for (size_t n = 0; n < dense.size(); ++n) {
      const int x = static_cast<int>(n) % dims[0], y = static_cast<int>(n) / dims[0] % dims[1],
                z = static_cast<int>(n) / (dims[0] * dims[1]);
      const bool box = filled == 1 || ((x / 11 + y / 13 + z / 9) & 1) == 0;
      const float v = value(random);
      dense[n] = box && (v + 3) / 6 < filled ? v : 0.0f;
    }
    slice.coset[c] = test::layer_from_dense(slice.lattice, c, dense);
  }
  slice.bounds = {-3, 3};
  return slice;
}

// Returns the coefficient at planes of either parity, mirrored; 0 where no site or no point is.
float site_at(const Slice& slice, const Int3& plane) {
  const bool bcc = slice.lattice.bcc;
  const int c = bcc ? plane[0] & 1 : 0;
  if (bcc && ((plane[1] & 1) != c || (plane[2] & 1) != c)) return 0;
  Int3 i;
  for (size_t a = 0; a < 3; ++a) i[a] = slice.lattice.mirror(a, c, bcc ? (plane[a] - c) / 2 : plane[a]);
  return slice.coset[c].value(i[0], i[1], i[2]);
}

using Case = std::tuple<bool, Int3, double>;
class SplatPointsOf : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Slices, SplatPointsOf,
                         testing::Values(Case{true, {70, 45, 38}, 1}, Case{true, {69, 40, 37}, 0.6},
                                         Case{true, {100, 90, 51}, 0.01}, Case{true, {1, 2, 5}, 1},
                                         Case{false, {40, 23, 17}, 1}, Case{false, {41, 30, 25}, 0.3},
                                         Case{false, {3, 1, 2}, 1}));

TEST_P(SplatPointsOf, ASliceAreItsSitesAndTheirMirrors) {
  const auto& [bcc, last, filled] = GetParam();
  const Slice slice = random_slice(bcc, last, filled, 3);
  TestContext context(2);
  const SplatPoints points = make_points(slice, context.get());

  const int m = points.margin;
  const auto inside = [&](const Int3& p) {
    bool in = true;
    for (size_t a = 0; a < 3; ++a) in = in && p[a] >= -m && p[a] <= slice.lattice.last[a] + m;
    return in;
  };
  std::vector<float> table; // of all planes
  const auto at = [&](const Int3& p) {
    if (!inside(p)) return 0.0f;
    const int nx = slice.lattice.last[0] + 2 * m + 1, ny = slice.lattice.last[1] + 2 * m + 1;
    return table[((p[2] + m) * ny + p[1] + m) * nx + p[0] + m];
  };
  uint64_t expected = 0;
  for (int z = -m; z <= last[2] + m; ++z)
    for (int y = -m; y <= last[1] + m; ++y)
      for (int x = -m; x <= last[0] + m; ++x) {
        table.push_back(site_at(slice, {x, y, z}));
        expected += table.back() != 0;
      }
  EXPECT_EQ(points.count, expected);

  size_t before = 0;
  for (size_t n = 0; n < points.bricks.size(); ++n) {
    const SplatBrick& b = points.bricks[n];
    ASSERT_GT(b.count, 0u);
    ASSERT_TRUE(n == 0 || points.slot(b) > before);
    before = points.slot(b);
    std::set<uint16_t> seen;
    std::array<uint8_t, 3> low{255, 255, 255}, high{};
    for (uint32_t i = b.first; i < b.first + b.count; ++i) {
      const uint16_t p = points.position[i];
      const Int3 local{p & 15, p >> 4 & 15, p >> 8 & 15};
      ASSERT_EQ(points.coefficient[i],
                at({b.plane[0] + local[0], b.plane[1] + local[1], b.plane[2] + local[2]}));
      seen.insert(p);
      for (size_t a = 0; a < 3; ++a) {
        ASSERT_LT(local[a], points.edge);
        low[a] = std::min(low[a], static_cast<uint8_t>(local[a]));
        high[a] = std::max(high[a], static_cast<uint8_t>(local[a]));
      }
    }
    ASSERT_EQ(seen.size(), b.count);
    ASSERT_EQ(b.low, low);
    ASSERT_EQ(b.high, high);

    // Cells and codes are made again from the sites themselves.
    const auto range = [&](const Int3& from, const Int3& to) { // over sites, planes counted in the brick
      CellRange r{1e9f, -1e9f};
      for (int z = from[2]; z < to[2]; ++z)
        for (int y = from[1]; y < to[1]; ++y)
          for (int x = from[0]; x < to[0]; ++x) {
            if (bcc && ((x & 1) != (y & 1) || (x & 1) != (z & 1))) continue;
            const float c = at({b.plane[0] + x, b.plane[1] + y, b.plane[2] + z});
            r = {std::min(r.low, c), std::max(r.high, c)};
          }
      return r;
    };
    const int e = points.edge;
    const CellRange own = range({0, 0, 0}, {e, e, e}), around = range({-e, -e, -e}, {2 * e, 2 * e, 2 * e});
    ASSERT_EQ(b.coefficient[0], std::min(own.low, 0.0f));
    ASSERT_EQ(b.coefficient[1], std::max(own.high, 0.0f));
    ASSERT_EQ(b.reach[0], std::min(around.low, 0.0f));
    ASSERT_EQ(b.reach[1], std::max(around.high, 0.0f));
    for (size_t r = 0; r < points.cell_reach.size(); ++r)
      for (int z = 0; z < e / 4; ++z)
        for (int y = 0; y < e / 4; ++y)
          for (int x = 0; x < e / 4; ++x) {
            if ((n + (x + 2 * y + z) + r) % 7 != 0) continue; // some of them
            const int reach = SplatPoints::cell_reach[r];
            const CellRange expect = range({4 * (x - reach), 4 * (y - reach), 4 * (z - reach)},
                                           {4 * (x + reach + 1), 4 * (y + reach + 1), 4 * (z + reach + 1)});
            const CellRange got = points.cells[r][n * cells_per_brick + (x | y << 2 | z << 4)];
            ASSERT_EQ(got.low, expect.low) << r << ' ' << x << ' ' << y << ' ' << z;
            ASSERT_EQ(got.high, expect.high) << r << ' ' << x << ' ' << y << ' ' << z;
          }
    for (int z = 0; z < e; z += 2)
      for (int y = 0; y < e; y += 2)
        for (int x = 0; x < e; x += 2) {
          const CellRange c = range({x, y, z}, {x + 2, y + 2, z + 2});
          ASSERT_EQ(points.codes[n * SplatPoints::fine_cells +
                                 fine_cell(static_cast<unsigned>(x | y << 4 | z << 8))],
                    points.code(std::max(std::fabs(c.low), std::fabs(c.high))));
        }
  }
}

// The order of a brick's points is part of the pictures' bits.
TEST(SplatPoints, KeepOneOrder) {
  const SiteOrder order(true);
  ASSERT_EQ(order.position.size(), 1024u);
  const Slice slice = random_slice(true, {40, 40, 40}, 0.5, 4);
  TestContext context(2);
  const SplatPoints points = make_points(slice, context.get());
  std::vector<size_t> place(1 << 12);
  for (size_t n = 0; n < order.position.size(); ++n) place[order.position[n]] = n;
  for (const SplatBrick& b : points.bricks)
    for (uint32_t n = b.first + 1; n < b.first + b.count; ++n)
      ASSERT_LT(place[points.position[n - 1]], place[points.position[n]]);
}

TEST(BrickSites, ArePlainCodeOnEveryTarget) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> value(-2, 2);
  SplatPoints points;
  points.code_unit = 0.25f;
  const SiteOrder order(true);
  for (const unsigned share : {0u, 1u, 30u, 99u, 100u}) {
    BrickSites sites;
    for (float& c : sites.coefficient) c = random() % 100 < share ? value(random) : 0.0f;
    if (share == 1) sites.coefficient[5] = -0.0f; // no point either
    SplatBrick expected, got;
    BrickCells expected_cells, cells;
    std::array<uint8_t, SplatPoints::fine_cells> expected_codes, codes;
    summarise_reference(sites, true, expected, expected_cells);
    code_cells_reference(sites, true, points, expected_codes.data());
    std::vector<uint16_t> expected_position(expected.count), position;
    std::vector<float> expected_coefficient(expected.count), coefficient;
    list_points_reference(sites, order, expected.count, expected_position.data(),
                          expected_coefficient.data());
    for_targets([&] {
      summarise(sites, true, got, cells);
      code_cells(sites, true, points, codes.data());
      position.assign(expected.count + 1, 7), coefficient.assign(expected.count + 1, 7);
      list_points(sites, order, got.count, position.data(), coefficient.data());
      EXPECT_EQ(got.count, expected.count);
      EXPECT_EQ(got.low, expected.low);
      EXPECT_EQ(got.high, expected.high);
      EXPECT_EQ(got.coefficient[0], expected.coefficient[0]);
      EXPECT_EQ(got.coefficient[1], expected.coefficient[1]);
      EXPECT_EQ(cells.low, expected_cells.low);
      EXPECT_EQ(cells.high, expected_cells.high);
      EXPECT_EQ(codes, expected_codes);
      EXPECT_TRUE(std::equal(expected_position.begin(), expected_position.end(), position.begin()));
      EXPECT_TRUE(std::equal(expected_coefficient.begin(), expected_coefficient.end(), coefficient.begin()));
      EXPECT_EQ(position.back(), 7); // the next brick's
      EXPECT_EQ(coefficient.back(), 7.0f);
    });
  }
}

TEST(CellRanges, ArePlainCodeOnEveryTarget) {
  std::mt19937 random(10);
  std::uniform_real_distribution<float> value(-2, 2);
  CellCube cube;
  for (size_t n = 0; n < cube.low.size(); ++n) cube.low[n] = value(random), cube.high[n] = value(random);
  std::array<std::array<CellRange, cells_per_brick>, 3> expected, got;
  const auto into = [](auto& a) { return WidenedCells{a[0].data(), a[1].data(), a[2].data()}; };
  widen_cells_reference(cube, into(expected));
  for_targets([&] {
    CellCube work = cube;
    widen_cells(work, into(got));
    for (size_t r = 0; r < got.size(); ++r)
      for (size_t n = 0; n < cells_per_brick; ++n) {
        ASSERT_EQ(got[r][n].low, expected[r][n].low) << r << ' ' << n;
        ASSERT_EQ(got[r][n].high, expected[r][n].high) << r << ' ' << n;
      }
  });
}

} // namespace
} // namespace bccsplat
