// SPDX-License-Identifier: Apache-2.0
#include "points/crop.h"

#include <gtest/gtest.h>

#include <memory>

namespace bccsplat {
namespace {

// A number of a site, and from it whether it is kept, and a hole.
int number(int x, int y, int z) { return (x + 41 * y + 41 * 37 * z) % 1009; }
bool kept(int n) { return n % 3 == 0; }
bool hole(int n) { return n % 5 == 1; }

int index_in(int x, int y, int z) { return (z % 16 * 16 + y % 16) * 16 + x % 16; }

TEST(CropLayer, EverySiteIsWhatItWasWithItsMarks) {
  const Lattice3 wide{false, {40, 36, 34}}, inner{false, {33, 30, 31}};
  const Int3 first{5, 3, 2};
  BrickLayer layer(wide, 0);
  for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
    if (slot == 1) continue; // air
    const Int3 b = layer.slot_position(slot);
    const auto brick = std::make_shared<Brick>();
    brick->hole = std::make_unique<BrickMask>();
    for (int s = 0; s < brick_sites; ++s) {
      const int x = b[0] * 16 + s % 16, y = b[1] * 16 + s / 16 % 16, z = b[2] * 16 + s / 256;
      if (x >= layer.dims()[0] || y >= layer.dims()[1] || z >= layer.dims()[2]) continue;
      const int n = number(x, y, z), bit = 1 << (s % 16);
      if (kept(n)) brick->value[s] = static_cast<float>(n + 1);
      if (kept(n)) brick->kept[s / 16] = static_cast<uint16_t>(brick->kept[s / 16] | bit);
      if (hole(n)) (*brick->hole)[s / 16] = static_cast<uint16_t>((*brick->hole)[s / 16] | bit);
    }
    layer.set(slot, brick);
  }
  const BrickLayer cropped = crop_layer(layer, inner, first);
  for (int z = 0; z < cropped.dims()[2]; ++z)
    for (int y = 0; y < cropped.dims()[1]; ++y)
      for (int x = 0; x < cropped.dims()[0]; ++x) {
        const int X = x + first[0], Y = y + first[1], Z = z + first[2], n = number(X, Y, Z),
                  s = index_in(x, y, z);
        const bool air = layer.slot(X / 16, Y / 16, Z / 16) == 1;
        const Brick* brick = cropped.brick(x / 16, y / 16, z / 16);
        ASSERT_TRUE(brick);
        ASSERT_EQ(brick->value[s], !air && kept(n) ? static_cast<float>(n + 1) : 0.0f)
            << x << ' ' << y << ' ' << z;
        ASSERT_EQ(brick->kept[s / 16] >> (s % 16) & 1, !air && kept(n) ? 1 : 0) << x << ' ' << y << ' ' << z;
        ASSERT_EQ(brick->is_hole(s), !air && hole(n)) << x << ' ' << y << ' ' << z;
      }
}

TEST(CropLayer, WhereNothingIsKeptIsAir) {
  const Lattice3 wide{false, {40, 40, 40}}, inner{false, {20, 20, 20}};
  EXPECT_EQ(crop_layer(BrickLayer(wide, 0), inner, {3, 3, 3}).bricks(), 0u);
}

} // namespace
} // namespace bccsplat
