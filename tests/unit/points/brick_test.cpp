// SPDX-License-Identifier: Apache-2.0
#include "points/brick.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>

namespace bccsplat {
namespace {

TEST(Brick, RowsKnowWhetherTheyHoldAny) {
  Lattice3 lattice;
  lattice.last = {90, 120, 70};
  BrickLayer layer(lattice, 0);
  const auto brick = std::make_shared<const Brick>();
  std::mt19937 random(1);
  for (int step = 0; step < 2000; ++step) {
    const size_t slot = random() % layer.brick_slots();
    layer.set(slot, random() % 2 ? brick : nullptr);
    for (size_t r = 0; r < layer.rows(); ++r) {
      bool any = false;
      for (size_t x = 0; x < layer.row_slots(); ++x) any = any || layer.brick(r * layer.row_slots() + x);
      ASSERT_EQ(layer.row_empty(r), !any) << step << " row " << r;
    }
  }
}

TEST(Brick, DifferentSlotsOfARowAreSetAtOnce) {
  Lattice3 lattice;
  lattice.last = {3000, 20, 20};
  BrickLayer layer(lattice, 0);
  const auto brick = std::make_shared<const Brick>();
  const auto fill = [&](size_t from, bool clear) {
    for (int round = 0; round < 200; ++round)
      for (size_t s = from; s < layer.row_slots(); s += 2)
        layer.set(s, round == 199 && clear ? nullptr : brick);
  };
  std::thread other(fill, 0, true);
  fill(1, true);
  other.join();
  EXPECT_TRUE(layer.row_empty(0));
  EXPECT_EQ(layer.kept_sites(), 0);
}

} // namespace
} // namespace bccsplat
