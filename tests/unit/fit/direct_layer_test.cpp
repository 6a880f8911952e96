// SPDX-License-Identifier: Apache-2.0
// Layers that a host gives as samples of the lattice: where one is missing the others go on.
#include "fit/direct_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "fit/kept/site_block.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"

namespace bccsplat::test {
namespace {

// The axes have lengths of their own, and the gap lies beyond the shorter ones.
TEST(DirectLayer, WhatIsMissingIsFilledAtAnyPlaceAndMarked) {
  TestContext context;
  const Lattice4 lattice = Lattice4::fit(LatticeKind::cc, {9, 7, 24, 3});
  const BrickLayer shape(lattice.space, 0);
  const Int3 n = shape.dims();
  ASSERT_GE(n[2], 20);
  const auto field = [](int x, int y, int z) {
    return 50 + 0.5f * static_cast<float>(z) + 0.25f * static_cast<float>(x - y);
  };
  const auto is_missing = [](int x, int y, int z) { return x < 4 && y > 2 && z >= 17 && z < 19; };
  std::vector<float> samples;
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x)
        samples.push_back(is_missing(x, y, z) ? std::numeric_limits<float>::quiet_NaN() : field(x, y, z));
  SiteBlockPool pool(context.memory);
  const FrameSites sites = layer_sites(shape, samples, 0, NonFinite::hole, {0, 0}, pool, context.get());
  double most = 0;
  size_t marked = 0;
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        const size_t slot = shape.slot(x / brick_edge, y / brick_edge, z / brick_edge);
        const int row = z % brick_edge * brick_edge + y % brick_edge;
        const auto& block = static_cast<const FloatSites&>(*sites.block[0][slot]);
        most = larger(most, std::fabs(block.value[row * brick_edge + x % brick_edge] - field(x, y, z)));
        const auto& mask = sites.holes[0][slot];
        const bool hole = mask && (*mask)[row] >> (x % brick_edge) & 1;
        EXPECT_EQ(hole, is_missing(x, y, z)) << x << ' ' << y << ' ' << z;
        marked += hole ? 1 : 0;
      }
  EXPECT_GT(marked, 8u);
  EXPECT_LT(most, 2);
}

} // namespace
} // namespace bccsplat::test
