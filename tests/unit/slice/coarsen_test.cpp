// SPDX-License-Identifier: Apache-2.0
// Slices of half the resolution: what the low pass keeps and what it takes away.
#include "slice/coarsen.h"

#include <gtest/gtest.h>

#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

// Returns the largest deviation of the slice from `f` (index space) at points of the domain.
double deviation(const Slice& slice, const Field3& f) {
  double most = 0;
  for (int n = 0; n < 400; ++n) {
    Vec3 p;
    for (size_t a = 0; a < 3; ++a)
      p[a] = slice.domain_end[a] * std::fmod(0.5 + n * std::array{0.8192, 0.6710, 0.5497}[a], 1.0);
    const Vec3 at = slice.lattice_to_slice.point(p);
    most = larger(most, std::fabs(evaluate_reference(slice, p, nullptr) - f(at[0], at[1], at[2])));
  }
  return most;
}

class Coarsen : public testing::TestWithParam<LatticeKind> {
 protected:
  TestContext context_;
  Slice make(const std::array<uint32_t, 3>& dims, const Field3& f, double air = 0) const {
    return make_slice(dims, f, "default", {}, air, GetParam());
  }
};
INSTANTIATE_TEST_SUITE_P(Slice, Coarsen, testing::Values(LatticeKind::bcc, LatticeKind::cc),
                         [](const auto& instance) {
                           return instance.param == LatticeKind::bcc ? "bcc" : "cc";
                         });

TEST_P(Coarsen, KeepsConstantsDomainAndWorld) {
  for (const std::array<uint32_t, 3>& dims : {std::array<uint32_t, 3>{24, 24, 24}, {25, 18, 31}, {7, 5, 4}}) {
    const Slice fine = make(dims, [](double, double, double) { return 3; });
    const Slice coarse = coarsen(fine, context_.get());
    EXPECT_LT(deviation(coarse, [](double, double, double) { return 3; }), 3 * 0.006); // the kernel's ripple
    const Vec3 a = fine.lattice_to_slice.point(fine.domain_end),
               b = coarse.lattice_to_slice.point(coarse.domain_end);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-9);
    EXPECT_TRUE(fine.slice_to_world == coarse.slice_to_world);
  }
}

TEST_P(Coarsen, HoldsAnEighthOfThePoints) {
  const Slice fine = make({48, 48, 48}, marschner_lobb(48, 2));
  const double part =
      static_cast<double>(coarsen(fine, context_.get()).points()) / static_cast<double>(fine.points());
  EXPECT_GT(part, 1 / 8.5);
  EXPECT_LT(part, 1 / 6.5); // both ends of every axis are kept
}

TEST_P(Coarsen, PassesLongWavesAndStopsShortOnes) {
  // Waves that mirror themselves at the ends: an odd and an even number of planes.
  for (const uint32_t n : {33u, 36u}) {
    const auto wave = [&](int half_periods) {
      return
          [=](double x, double, double) { return std::cos(std::numbers::pi * half_periods / (n - 1) * x); };
    };
    const auto slow = static_cast<int>(n) / 10,
               fast = static_cast<int>(n) - 4; // of the old Nyquist rate: 0.1, 0.9
    EXPECT_LT(deviation(coarsen(make({n, n, n}, wave(slow)), context_.get()), wave(slow)), 0.06);
    // What is left of short waves may be anywhere.
    const Slice rest = coarsen(make({n, n, n}, wave(fast)), context_.get());
    EXPECT_LT(deviation(rest, [](double, double, double) { return 0; }), 0.2);
  }
}

TEST_P(Coarsen, IsLinear) {
  const Field3 f = marschner_lobb(20, 3),
               g = [](double x, double y, double z) { return 0.02 * (x + 2 * y - z); };
  const Slice a = coarsen(make({20, 20, 20}, f), context_.get()),
              b = coarsen(make({20, 20, 20}, g), context_.get());
  const Slice sum = coarsen(
      make({20, 20, 20}, [&](double x, double y, double z) { return 2 * f(x, y, z) - 3 * g(x, y, z); }),
      context_.get());
  for (int n = 0; n < 100; ++n) {
    const Vec3 p{0.09 * n, 0.07 * n + 0.2, 0.05 * n + 1};
    EXPECT_NEAR(evaluate_reference(sum, p, nullptr),
                2 * evaluate_reference(a, p, nullptr) - 3 * evaluate_reference(b, p, nullptr), 2e-3);
  }
}

TEST_P(Coarsen, KeepsAirEmpty) {
  // A ball in the corner of an empty domain: bricks away from it hold nothing.
  const Slice fine = make({90, 90, 90}, [](double x, double y, double z) {
    return std::max(0.0, 1 - std::hypot(x - 12, y - 12, z - 12) / 8);
  });
  const Slice coarse = coarsen(fine, context_.get());
  EXPECT_GT(coarse.points(), fine.points() / 12);
  EXPECT_LT(coarse.points(), fine.points() / 2); // the skirt of the low pass included
}

TEST(Coarsen, CarriesHoles) {
  TestContext context;
  Slice fine = make_slice({40, 40, 40}, [](double, double, double) { return 1; });
  for (BrickLayer& layer : fine.coset) { // missing from x = 20 T on
    BrickLayer holed = layer;
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      auto b = std::make_shared<Brick>();
      b->value = layer.brick(s)->value, b->kept = layer.brick(s)->kept;
      b->hole = std::make_unique<BrickMask>();
      for (int i = 0; i < brick_sites; ++i) {
        const Int3 brick = layer.slot_position(s);
        const Vec3 p = fine.site(layer.coset(), {brick[0] * 16 + i % 16, 0, 0});
        if (p[0] >= 20) (*b->hole)[i / 16] |= static_cast<uint16_t>(1u << (i % 16));
      }
      holed.set(s, b);
    }
    layer = holed;
  }
  fine.has_holes = true;
  const Slice coarse = coarsen(fine, context.get());
  ASSERT_TRUE(coarse.has_holes);
  for (double x = 0.5; x < 19; x += 0.7) // lattice units of the new slice: two T
    EXPECT_EQ(coarse.is_hole({x, 7.3, 9.1}), x > 10) << x;
}

} // namespace
} // namespace bccsplat
