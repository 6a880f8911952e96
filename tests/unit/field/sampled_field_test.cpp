// SPDX-License-Identifier: Apache-2.0
// The samples of a volume that stores coefficients: the field of its kernel at the sites.
#include "field/coefficients/sampled_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "field/evaluate.h"
#include "fit/layer_window.h"
#include "kernel/cc_kernel.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::TestContext;

// A series of noise in [-1, 1], some bricks of it air, as coefficients of a kernel.
LayerWindow noise_coefficients(const Lattice4& lattice, const std::string& kernel) {
  LayerWindow window(lattice, 2.5f, make_kernel(kernel).name);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-1, 1);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int c = lattice.coset(m);
    std::vector<float> dense(static_cast<size_t>(lattice.space.sites(c)));
    for (float& v : dense) v = value(random);
    BrickLayer layer = layer_from_dense(lattice.space, c, dense);
    for (size_t s = 0; s + 1 < layer.brick_slots(); ++s)
      if (random() % 3 == 0) layer.set(s, nullptr);
    window.push(std::move(layer));
  }
  return window;
}

TEST(SampledField, IsTheFieldAtTheSites) {
  TestContext context;
  struct Case {
    LatticeKind kind;
    std::array<uint32_t, 4> dims;
    const char* kernel;
  };
  for (const auto& [kind, dims, kernel] :
       {Case{LatticeKind::d4star, {30, 25, 12, 6}, "default"},
        Case{LatticeKind::d4star, {24, 9, 40, 5}, "fine"}, Case{LatticeKind::d4star, {9, 8, 7, 9}, "fast"},
        Case{LatticeKind::bcc, {30, 25, 24, 1}, "default"}, Case{LatticeKind::cc, {18, 17, 9, 5}, "default"},
        Case{LatticeKind::cc, {18, 17, 9, 1}, "fast"}}) {
    SCOPED_TRACE(std::string(kernel) + " on kind " + std::to_string(static_cast<int>(kind)));
    const Lattice4 lattice = Lattice4::fit(kind, dims);
    const LayerWindow stored = noise_coefficients(lattice, kernel);
    const Kernel own = lattice.space.bcc ? make_kernel(kernel) : make_cc_kernel(kernel).kernel;
    const SampledField sampled(stored, own, 0);
    const Coefficients field(stored, 0, make_kernel(kernel), 0, uint64_t{1} << 30);
    EXPECT_TRUE(sampled.coefficient_kernel().empty());
    EXPECT_EQ(sampled.air(0), 2.5f);
    std::vector<Vec4> points;
    std::vector<float> expected;
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const int c = lattice.coset(m);
      const BrickLayer layer = sampled.read_layer(0, m, {}, context.get());
      const Int3 n = lattice.space.dims(c);
      for (int z = 0; z < n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
          for (int x = 0; x < n[0]; ++x) {
            const Vec3 p = lattice.site_position(c, {x, y, z});
            points.push_back({p[0], p[1], p[2], lattice.is_static() ? 0 : lattice.layer_frame(m)});
            expected.push_back(layer.value(x, y, z));
          }
    }
    std::vector<float> values(points.size());
    std::vector<uint8_t> holes(points.size());
    evaluate4_mirrored(field, points, values, {}, holes, context.get());
    for (size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(values[i], expected[i], 4e-6) << "site " << i;
  }
}

// Bricks outside the region are absent, those inside are as without one.
TEST(SampledField, OfARegion) {
  TestContext context;
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {60, 25, 60, 6});
  const LayerWindow stored = noise_coefficients(lattice, "default");
  const SampledField sampled(stored, make_kernel("default"), 0);
  const BrickBox region{{1, 0, 1}, {2, 1, 3}};
  const BrickLayer all = sampled.read_layer(0, 3, {}, context.get()),
                   some = sampled.read_layer(0, 3, region, context.get());
  for (size_t s = 0; s < all.brick_slots(); ++s) {
    if (!region.contains(all.slot_position(s))) {
      EXPECT_EQ(some.brick(s), nullptr);
      continue;
    }
    ASSERT_EQ(all.brick(s) != nullptr, some.brick(s) != nullptr);
    if (all.brick(s)) {
      EXPECT_EQ(all.brick(s)->value, some.brick(s)->value);
    }
  }
}

} // namespace
} // namespace bccsplat
