// SPDX-License-Identifier: Apache-2.0
// Nothing near a stored point, its mirror image or a hole may be skipped.
#include "slice/occupancy.h"

#include <gtest/gtest.h>

#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "slice/hyperslice.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::sample_field;
using test::TestContext;

TEST(Occupancy, FindsEveryPointAndItsImages) {
  TestContext context;
  std::mt19937 random(3);
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const auto lattice = Lattice4::fit(kind, {60, 40, 50, 30});
    for (int round = 0; round < 200; ++round) {
      const auto m = static_cast<int32_t>(random() % static_cast<uint32_t>(lattice.layers()));
      const int c = lattice.coset(m);
      BrickLayer layer(lattice.space, c);
      Int3 site;
      for (size_t a = 0; a < 3; ++a)
        site[a] = static_cast<int>(random() % static_cast<uint32_t>(layer.dims()[a]));
      auto brick = std::make_shared<Brick>();
      const size_t row = site[2] % 16 * 16 + site[1] % 16;
      if (round % 2) {
        brick->kept[row] = static_cast<uint16_t>(1 << site[0] % 16);
      } else {
        brick->hole = std::make_unique<BrickMask>();
        (*brick->hole)[row] = static_cast<uint16_t>(1 << site[0] % 16);
      }
      layer.set(layer.slot(site[0] / 16, site[1] / 16, site[2] / 16), std::move(brick));
      Occupancy o(lattice);
      o.add(m, layer);
      const Vec3 p = lattice.site_position(c, site);
      Vec4 at{p[0], p[1], p[2], lattice.layer_frame(m)}, low, high;
      for (size_t a = 0; a < 4; ++a) { // some of them as images beyond an end
        const double end =
            a < 3 ? lattice.space.last[a] * lattice.space_step[a] : lattice.layer_frame(lattice.last_layer);
        const auto image = random() % 3;
        if (image == 1) at[a] = -at[a];
        if (image == 2) at[a] = 2 * end - at[a];
        low[a] = at[a] - 0.01, high[a] = at[a] + 0.01;
      }
      EXPECT_TRUE(o.any(low, high));
      // Somewhere else, further than a cell, there is nothing.
      for (size_t a = 0; a < 4; ++a) {
        Vec4 from = low, to = high;
        const double middle = (lattice.dims[a] - 1.0) / 2, own = a < 3 ? p[a] : lattice.layer_frame(m);
        const double other = own < middle ? own + 8 : own - 8;
        from[a] = other - 0.5, to[a] = other + 0.5;
        EXPECT_FALSE(o.any(from, to)) << a;
      }
    }
  }
}

TEST(Occupancy, SkippingChangesNothing) {
  // Two small balls in air: a slice that may skip, and one whose cache is too small to know what it may skip.
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {32, 28, 30, 20});
  const auto samples = sample_field(lattice, [](const Vec4& p) {
    const auto ball = [&](double x, double y, double z) {
      const double r2 = std::pow(p[0] - x, 2) + std::pow(p[1] - y, 2) + std::pow(p[2] - z, 2);
      return r2 < 16 ? std::pow(1 - r2 / 16, 2) : 0.0;
    };
    return ball(8 + 0.5 * p[3], 14, 12) + ball(28, 3, 24 - 0.5 * p[3]);
  });
  const struct {
    Hyperplane plane;
    Thickness thickness;
  } cuts[] = {{{0.7, 0.1, 0.2, 0.6, -20}, {}},
              {{0.7, 0.1, 0.2, 0.6, -20}, {5, ThicknessKind::mean}},
              {{0.5, 0.5, 0.5, 0.5, -28}, {5, ThicknessKind::sum}},
              {{0.5, 0.5, 0.5, 0.5, -28}, {5, ThicknessKind::maximum}}};
  for (const auto& cut : cuts) {
    HypersliceOptions o;
    o.thickness = cut.thickness;
    const Coefficients c(samples, 0, make_kernel("default"), 0, 1u << 30);
    const Coefficients small(samples, 0, make_kernel("default"), 0, 1u << 16);
    const Slice a = hyperslice(c, cut.plane, o, {}, context.get());
    const Slice b = hyperslice(small, cut.plane, o, {}, context.get());
    EXPECT_GT(a.points(), 100);
    for (size_t k = 0; k < 2; ++k) EXPECT_EQ(layer_to_dense(a.coset[k]), layer_to_dense(b.coset[k]));
  }
}

} // namespace
} // namespace bccsplat
