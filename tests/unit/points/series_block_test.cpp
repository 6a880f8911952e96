// SPDX-License-Identifier: Apache-2.0
// Boxes of a series: what is left of one without another, and which bricks are whose.
#include <gtest/gtest.h>

#include "points/series_block.h"

namespace bccsplat {
namespace {

uint64_t samples(const SeriesBlock& b) {
  uint64_t n = 1;
  for (size_t a = 0; a < 4; ++a) n *= b.end[a] - b.begin[a];
  return n;
}

TEST(SeriesBlock, WithoutAnotherLeavesTheRest) {
  const SeriesBlock box{{2, 3, 4, 5}, {12, 13, 14, 15}};
  const SeriesBlock taken{{0, 5, 6, 7}, {7, 20, 8, 9}};
  const SeriesBlock both = box.cut(taken);
  const std::vector<SeriesBlock> left = without(box, taken);
  uint64_t sum = samples(both);
  for (size_t i = 0; i < left.size(); ++i) {
    sum += samples(left[i]);
    EXPECT_TRUE(left[i].cut(taken).empty());
    EXPECT_EQ(left[i].cut(box), left[i]);
    for (size_t j = 0; j < i; ++j) EXPECT_TRUE(left[i].cut(left[j]).empty());
  }
  EXPECT_EQ(sum, samples(box));
  EXPECT_TRUE(without(box, box).empty());
  EXPECT_EQ(without(box, {{20, 0, 0, 0}, {30, 20, 20, 20}}), std::vector<SeriesBlock>{box});
}

TEST(SeriesBlock, BlocksShareTheBricksAtEveryDistance) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const double scale : {.6, 1.0, 2.0, 8.0})
      for (const int32_t margin : {0, 2}) {
        const Lattice4 lattice =
            Lattice4::fit(kind, {150, 20, 20, 4}, {scale, scale, scale, 1}, 0, {margin, 0, 0});
        const int32_t bricks = (lattice.space.dims(0)[0] + brick_edge - 1) / brick_edge;
        for (uint32_t border = 1; border < 150; ++border) {
          const BrickBox first = bricks_of({{0, 0, 0, 0}, {border, 20, 20, 4}}, lattice);
          const BrickBox last = bricks_of({{border, 0, 0, 0}, {150, 20, 20, 4}}, lattice);
          EXPECT_EQ(first.begin[0], 0);
          EXPECT_EQ(first.end[0], last.begin[0]);
          EXPECT_EQ(last.end[0], bricks);
          if (first.end[0] == bricks || first.end[0] == 0) continue;
          const auto place = [&](int32_t b) { return lattice.site_position(0, {16 * b, 0, 0})[0]; };
          EXPECT_GE(place(first.end[0]), border);
          EXPECT_LT(place(first.end[0] - 1), border);
        }
      }
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {150, 20, 20, 4});
  EXPECT_EQ(bricks_of(SeriesBlock::of_frames(0, 2), lattice), BrickBox{});
}

// No site that is left out stands so near, and those of the bricks at the ends do.
TEST(SeriesBlock, BricksNearASampleHaveTheSitesAroundIt) {
  constexpr int32_t sites = 4;
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const double scale : {.6, 1.0, 2.0})
      for (const int32_t margin : {0, 2}) {
        const Lattice4 lattice =
            Lattice4::fit(kind, {150, 20, 20, 4}, {scale, scale, scale, 1}, 0, {margin, 0, 0});
        const int32_t count = lattice.space.dims(0)[0];
        const auto place = [&](int32_t site) { return lattice.site_position(0, {site, 0, 0})[0]; };
        const double reach = sites * (place(1) - place(0));
        for (uint32_t begin = 0; begin < 150; begin += 7)
          for (const uint32_t length : {1u, 30u}) {
            const uint32_t end = std::min(begin + length, 150u);
            const BrickBox box = bricks_near({{begin, 0, 0, 0}, {end, 20, 20, 4}}, lattice, sites);
            for (int32_t site = 0; site < count; ++site) {
              const bool near = place(site) >= begin - reach && place(site) <= end - 1.0 + reach;
              const bool in = site / brick_edge >= box.begin[0] && site / brick_edge < box.end[0];
              EXPECT_TRUE(in || !near) << site << " of " << begin << " .. " << end;
            }
            EXPECT_GT(place(box.begin[0] * brick_edge + brick_edge), begin - reach - place(1) + place(0));
            EXPECT_LT(place((box.end[0] - 1) * brick_edge), end + reach + place(1) - place(0));
          }
      }
  EXPECT_EQ(bricks_near(SeriesBlock::of_frames(0, 2), Lattice4(), sites), BrickBox{});
}

} // namespace
} // namespace bccsplat
