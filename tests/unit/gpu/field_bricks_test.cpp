// SPDX-License-Identifier: Apache-2.0
// What is looked up in bricks is what the slice has, mirrored beyond its ends; cells that nothing is seen of.
#include "gpu/field_bricks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

Slice two_blobs() {
  return make_slice({150, 30, 26}, [](double x, double y, double z) {
    const double a = std::hypot(x - 8, y - 10, z - 9), b = std::hypot(x - 140, y - 18, z - 15);
    return std::max(0.0, 1 - a / 7) - std::max(0.0, 1 - b / 6);
  });
}

// The coefficient at a site of a coset, as a shader finds it.
float looked_up(const FieldBricks& b, int coset, const Int3& site, const Int3& away) {
  Int3 brick, in;
  for (size_t a = 0; a < 3; ++a) {
    const int from_first = site[a] - b.first_site[a];
    brick[a] = from_first / brick_edge, in[a] = from_first % brick_edge + b.border + away[a];
  }
  const size_t at =
      ((static_cast<size_t>(coset * b.bricks[2] + brick[2]) * b.bricks[1]) + brick[1]) * b.bricks[0] +
      brick[0];
  const size_t size = static_cast<size_t>(b.edge);
  return b.value[((b.brick_at[at] * size + in[2]) * size + in[1]) * size + in[0]];
}

TEST(FieldBricks, HoldEverySiteAndItsNeighbours) {
  TestContext context(2);
  const Slice s = two_blobs();
  for (const int border : {1, 2}) {
    const FieldBricks b = make_field_bricks(s, border, context.get());
    EXPECT_LT(b.count(),
              2 * static_cast<size_t>(b.bricks[0]) * b.bricks[1] * b.bricks[2]); // air is not there
    for (int coset = 0; coset < 2; ++coset)
      for (int z = -2; z < s.lattice.dims(coset)[2] + 2; ++z)
        for (int y = -2; y < s.lattice.dims(coset)[1] + 2; ++y)
          for (int x = -2; x < s.lattice.dims(coset)[0] + 2; ++x)
            for (const int away : {-border, 0, border}) {
              const float have = looked_up(b, coset, {x, y, z}, {away, -away, away});
              const float want = s.coset[static_cast<size_t>(coset)].value(
                  s.lattice.mirror(0, coset, x + away), s.lattice.mirror(1, coset, y - away),
                  s.lattice.mirror(2, coset, z + away));
              ASSERT_EQ(have, want) << coset << ' ' << x << ' ' << y << ' ' << z;
            }
  }
}

// The range of a point's cell bounds the field there.
TEST(FieldBricks, CellsBoundTheField) {
  TestContext context(2);
  const Slice s = two_blobs();
  const FieldBricks b = make_field_bricks(s, 1, context.get());
  size_t narrow = 0;
  for (int n = 0; n < 20000; ++n) {
    Vec3 p;
    std::array<size_t, 3> cell;
    for (size_t a = 0; a < 3; ++a) {
      p[a] = s.domain_end[a] * (std::rand() / (RAND_MAX + 1.0));
      cell[a] = static_cast<size_t>(std::floor(p[a] / std::numbers::sqrt2 + 0.5) - b.first_site[a]) / 2;
    }
    const auto& range = b.range[(cell[2] * b.cells[1] + cell[1]) * b.cells[0] + cell[0]];
    const auto [low, high] = coefficient_bounds(s, range);
    const double value = evaluate_reference(s, p, nullptr);
    EXPECT_TRUE(value >= low - 1e-6 && value <= high + 1e-6);
    narrow += high - low < 0.1 ? 1 : 0;
  }
  EXPECT_GT(narrow, 10000u);
}

TEST(FieldBricks, DistancesToWhatIsSeen) {
  const Int3 cells{9, 7, 5};
  const auto at = [&](int x, int y, int z) { return static_cast<size_t>((z * cells[1] + y) * cells[0] + x); };
  std::vector<uint8_t> marked(static_cast<size_t>(9 * 7 * 5));
  marked[at(1, 2, 3)] = marked[at(8, 0, 0)] = 1;
  for (const int around : {0, 2}) {
    const std::vector<uint8_t> unseen = cells_around(cells, around, marked);
    for (int z = 0; z < cells[2]; ++z)
      for (int y = 0; y < cells[1]; ++y)
        for (int x = 0; x < cells[0]; ++x) {
          const int a = std::max({std::abs(x - 1), std::abs(y - 2), std::abs(z - 3)}),
                    b = std::max({std::abs(x - 8), y, z});
          EXPECT_EQ(unseen[at(x, y, z)], std::max(0, std::min(a, b) - around)) << x << y << z;
        }
  }
  const std::vector<uint8_t> none = cells_around(cells, 1, std::vector<uint8_t>(marked.size()));
  EXPECT_EQ(*std::min_element(none.begin(), none.end()), 255);
}

} // namespace
} // namespace bccsplat
