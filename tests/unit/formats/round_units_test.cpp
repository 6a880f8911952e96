// SPDX-License-Identifier: Apache-2.0
// Rounding of sixteen rows side by side, against the formula, on every target.
#include "formats/bcc4/encode/round_units.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "formats/bcc4/encode/noise_shape.h"
#include "kernel/kernel.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

struct RoundingCase {
  LatticeKind kind = LatticeKind::d4star;
  std::array<uint32_t, 4> dims{40, 40, 40, 12};
  Int3 brick{0, 0, 0};
  int layers = 4;
  double filled = 1;      // share of the sites
  int air_layer = -1;     // which has no brick
  double size = 100;      // of values
  bool shaped = true;     // errors are handed on
  bool in_planes = false; // every third plane is filled, and every second row of it
};

struct Chunk {
  ChunkShape shape;
  std::vector<std::unique_ptr<Brick>> bricks;
  std::vector<const Brick*> all;
};

Chunk chunk_of(const RoundingCase& c) {
  std::mt19937 random(7);
  std::normal_distribution<float> value(0, static_cast<float>(c.size));
  std::uniform_real_distribution<double> share(0, 1);
  Chunk chunk;
  chunk.shape = chunk_shape(Lattice4::fit(c.kind, c.dims), 0, c.layers, c.brick);
  for (int m = 0; m < c.layers; ++m) {
    const Int3& n = chunk.shape.box[m];
    auto brick = m == c.air_layer ? nullptr : std::make_unique<Brick>();
    for (int z = 0; brick && z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const bool here = !c.in_planes || (z % 3 == 1 && y % 2 == 0);
          if (here && share(random) < c.filled)
            brick->value[(z * brick_edge + y) * brick_edge + x] = value(random);
        }
    chunk.all.push_back(brick.get());
    chunk.bricks.push_back(std::move(brick));
  }
  return chunk;
}

void expect_as_reference(const RoundingCase& c) {
  const Chunk chunk = chunk_of(c);
  UnitRounding how{.unit = 0.37, .most = 200, .weights = {}};
  if (c.shaped) {
    const NoiseShape shape = noise_shape(make_kernel("default"), c.kind == LatticeKind::bcc);
    for (int m = 0; m < c.layers; ++m) how.weights.push_back(taps_of_layer(shape, chunk.shape, m));
  }
  std::vector<LayerUnits> expected(chunk.all.size());
  round_units_reference(chunk.shape, chunk.all, how, expected);
  int others = 0;
  for (const LayerUnits& layer : expected)
    others += static_cast<int>(std::count_if(layer.begin(), layer.end(), [](int32_t u) { return u != 0; }));
  EXPECT_GT(others, 5);
  test::for_targets([&] {
    std::vector<LayerUnits> got(chunk.all.size());
    round_units(chunk.shape, chunk.all, how, got);
    for (size_t m = 0; m < got.size(); ++m) {
      const auto wrong = std::mismatch(got[m].begin(), got[m].end(), expected[m].begin());
      EXPECT_TRUE(wrong.first == got[m].end()) << "layer " << m << ", site " << wrong.first - got[m].begin()
                                               << ": " << *wrong.first << " instead of " << *wrong.second;
    }
  });
}

TEST(RoundUnits, FullChunksOfEveryLattice) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::bcc, LatticeKind::cc})
    for (const bool shaped : {true, false}) {
      SCOPED_TRACE(static_cast<int>(kind));
      expect_as_reference({.kind = kind,
                           .dims = {40, 40, 40, kind == LatticeKind::bcc ? 1u : 12u},
                           .layers = kind == LatticeKind::bcc ? 2 : 8,
                           .shaped = shaped});
    }
}

// Narrow bricks at the far faces, of which one coset has fewer sites, or none.
TEST(RoundUnits, BricksThatEndEarly) {
  for (const uint32_t edge : {32u, 33u, 34u, 45u, 63u, 64u, 65u})
    for (const Int3& brick : {Int3{1, 0, 0}, Int3{0, 1, 0}, Int3{0, 0, 1}, Int3{1, 1, 1}}) {
      SCOPED_TRACE(edge);
      const RoundingCase c{.dims = {edge, edge, edge, 12}, .brick = brick, .layers = 7};
      if (chunk_of(c).shape.sites() > 20) expect_as_reference(c);
    }
}

TEST(RoundUnits, SparseSitesRowsPlanesAndLayers) {
  for (const double filled : {0.9, 0.5, 0.03}) {
    expect_as_reference({.filled = filled});
    expect_as_reference({.filled = filled, .air_layer = 1});
    expect_as_reference({.filled = filled, .in_planes = true});
    expect_as_reference({.layers = 7, .filled = filled, .air_layer = 3, .in_planes = true});
  }
}

// Errors do not grow beyond what a unit can take, nor do units.
TEST(RoundUnits, ValuesBeyondAllUnits) {
  expect_as_reference({.size = 1e4});
  expect_as_reference({.size = 0.2});
}

} // namespace
} // namespace bccsplat
