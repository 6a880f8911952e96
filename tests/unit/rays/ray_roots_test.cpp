// SPDX-License-Identifier: Apache-2.0
// The loops of rays in lanes beside one ray at a time: roots between samples, and layers of cells, for any
// number of rays, whole vectors or not.
#include "rays/ray_roots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "rays/ray_lanes.h"
#include "shade/surface.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

struct Sampled {
  float value;
  Vec3 gradient;
};
Sampled sample(const SurfaceField& field, const Vec3& at) {
  std::array<float, 1> value;
  std::array<Vec3, 1> gradient;
  field_at(field, std::span(&at, 1), value, gradient);
  return {value[0], gradient[0]};
}

// Rays through a smooth field at random places, of which those are kept that pass the target in the next
// sheet.
std::vector<RootPair> pairs_of(const SurfaceField& field, const Vec3& ray, float target, size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(6, 14);
  std::vector<RootPair> pairs;
  while (pairs.size() < count) {
    const Vec3 low{place(random), place(random), place(random)};
    const Sampled a = sample(field, low), b = sample(field, low + ray);
    if ((a.value < target) == (b.value < target)) continue;
    const auto end = [&](const Sampled& s) {
      return RootEnd{s.value - target, static_cast<float>(dot(s.gradient, ray))};
    };
    pairs.push_back({low - 5.0 * ray, ray, 5, end(a), end(b), static_cast<uint32_t>(pairs.size())});
  }
  return pairs;
}

TEST(RayRoots, AreWhereTheFieldIsTheTargetForAnyNumber) {
  const Slice s = test::make_slice({30, 30, 30}, [](double x, double y, double z) {
    return 0.5 + 0.4 * std::sin(0.5 * x) * std::cos(0.4 * y + 0.3 * z);
  });
  const SurfaceField field(s);
  const Vec3 ray{0.5, 0.3, -0.7};
  const float target = 0.55f - s.base;
  const std::vector<RootPair> all = pairs_of(field, ray, target, 70);
  const auto roots = std::make_unique<RayRoots>(field.footprints, target);
  for (const size_t count : {size_t{1}, size_t{7}, size_t{16}, size_t{17}, size_t{33}, size_t{70}}) {
    roots->clear();
    EXPECT_TRUE(roots->empty());
    for (size_t n = 0; n < count; ++n) roots->add(all[n]);
    const auto found = roots->find();
    ASSERT_EQ(found.size(), count);
    std::vector<int> seen(count, 0);
    for (const RayRoot& root : found) {
      ASSERT_LT(root.number, count);
      ++seen[root.number];
      const RootPair& pair = all[root.number];
      EXPECT_GE(root.k, pair.sheet);
      EXPECT_LE(root.k, pair.sheet + 1);
      EXPECT_LT(length(root.position - (pair.origin + root.k * ray)), 1e-9);
      const Sampled at = sample(field, root.position);
      EXPECT_LT(std::fabs(at.value - target), 1e-3 * std::fabs(dot(at.gradient, ray)) + 1e-6);
      // What it is lit by is a sample near it.
      EXPECT_LT(length(root.sample.position - root.position), 1.001 * root_tolerance * length(ray));
      const Sampled near = sample(field, root.sample.position);
      EXPECT_EQ(static_cast<double>(near.value), root.sample.value);
      EXPECT_LT(length(near.gradient - root.sample.gradient), 1e-6);
    }
    EXPECT_EQ(seen, std::vector<int>(count, 1));
  }
}

// Roots of straight lines, each asked for a little before or behind it: those within the tolerance are taken.
TEST(RayRoots, AreTakenWhereTheLastSampleIsNear) {
  const std::vector<std::array<float, 4>> rays(RootLanes::room, {0, 0, 1, 9});
  RootArgs args{.count = 0, .ray = rays.data(), .target = 0.25f, .tolerance = 0.02f};
  const auto lanes = std::make_unique<RootLanes>();
  std::vector<float> values(RootLanes::room);
  const std::vector<std::array<float, 4>> gradients(RootLanes::room, {3, 5, 1, 7});
  const auto root_of = [](size_t n) { return 0.3f + 0.4f * static_cast<float>(n % 29) / 29; };
  const auto aside = [](size_t n) { return (n % 3 == 0 ? 0.06f : 0.01f) * (n % 2 == 0 ? 1.0f : -1.0f); };
  for (const size_t count : {1, 15, 16, 17, 63, 64, 65, 130, 1024}) {
    args.count = count;
    lanes->near.fill(0x5555555555555555); // of another search
    for (size_t n = 0; n < count; ++n) {
      lanes->low.x[n] = 0, lanes->low.value[n] = -root_of(n), lanes->low.slope[n] = 1;
      lanes->high.x[n] = 1, lanes->high.value[n] = 1 - root_of(n), lanes->high.slope[n] = 1;
      lanes->next[n] = root_of(n) + aside(n), values[n] = args.target + aside(n);
    }
    bracket_roots(args, values, gradients, *lanes);
    for (size_t n = 0; n < count; ++n) {
      EXPECT_EQ(lanes->near[n / 64] >> n % 64 & 1, n % 3 == 0 ? 0u : 1u) << n << " of " << count;
      EXPECT_NEAR(lanes->next[n], root_of(n), 1e-6) << n << " of " << count;
      const RootLanes::End& moved = aside(n) < 0 ? lanes->low : lanes->high;
      EXPECT_EQ(moved.x[n], root_of(n) + aside(n)) << n << " of " << count;
    }
  }
}

// Neighbours at random, beside the same rule for one pair at a time. Behind the last sample lies what another
// search left.
TEST(RayPairs, AreThoseThatPassTheTargetOrTurnTowardsIt) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  for (const size_t count : {1, 2, 15, 16, 17, 48, 63, 64, 65, 127, 129, 200}) {
    const size_t room = count + PairArgs::room;
    std::vector<float> value(room), slope(room);
    std::vector<std::array<float, 4>> gradient(room), ray(room);
    for (float& v : value) v = 2 + 0.5f * any(random);
    for (std::array<float, 4>& g : gradient) g = {any(random), any(random), any(random), any(random)};
    for (std::array<float, 4>& r : ray) r = {0.5f + any(random), any(random) - 1.5f, 2 + any(random), 5};
    std::vector<uint64_t> found(room / 64 + 1, ~uint64_t{0});
    const PairArgs args{count, value.data(), gradient.data(), ray.data(), 1.75f, slope.data(), found.data()};
    find_pairs(args);
    size_t crossings = 0, turns = 0;
    for (size_t n = 0; n < count; ++n) {
      const auto along = [&](size_t of) {
        double sum = 0;
        for (size_t a = 0; a < 3; ++a) sum += 1.0 * ray[of][a] * gradient[of][a];
        return sum;
      };
      EXPECT_NEAR(slope[n], along(n), 1e-5) << n << " of " << count;
      if (n + 1 == count) break; // the last one has no next
      const double d0 = value[n] - 1.75, d1 = value[n + 1] - 1.75, side = d0 < 0 ? 1 : -1;
      const bool crosses = (d0 < 0) != (d1 < 0);
      const double s0 = side * along(n), s1 = side * along(n + 1);
      const double meet = side * d0 * (s0 - s1) + s0 * (side * (d1 - d0) - s1);
      const bool turns_here = s0 > 0 && s1 < 0 && meet > 0;
      if (!crosses && s0 > 0 && s1 < 0 && std::fabs(meet) < 1e-4) continue; // rounding decides
      EXPECT_EQ(found[n / 64] >> n % 64 & 1, crosses || turns_here ? 1u : 0u) << n << " of " << count;
      crossings += crosses, turns += turns_here && !crosses;
    }
    if (count > 100) {
      EXPECT_GT(crossings, 10u);
      EXPECT_GT(turns, 3u);
    }
  }
}

// Rays through a slab of blocks, straight along it: each passes the column of cells that it stands in.
TEST(RayLayers, AreThoseOfTheBlockThatARayPasses) {
  constexpr int blocks_u = 3, blocks_v = 2;
  std::mt19937_64 random(11);
  std::array<uint64_t, blocks_u * blocks_v> bits;
  for (uint64_t& word : bits) word = random() & random();
  PassMasks mask_u, mask_v;
  for (size_t n = 0; n < 2 * PassMasks::places; ++n)
    for (uint64_t bit = 0; bit < 64; ++bit) {
      const int cell = static_cast<int>(n) / PassMasks::parts - block_edge;
      if (static_cast<int>(bit & 3) == cell) mask_u.words[n] |= uint64_t{1} << bit;
      if (static_cast<int>(bit >> 2 & 3) == cell) mask_v.words[n] |= uint64_t{1} << bit;
    }
  SlabArgs args;
  args.bits = bits.data();
  for (size_t bit = 0; bit < 64; ++bit) args.layer[bit >> 4] |= uint64_t{1} << bit;
  // Part of the rays lie before the first block or behind the last one.
  args.u = {0, blocks_u, 1, &mask_u}, args.v = {0, blocks_v, blocks_u, &mask_v};
  const auto rays = std::make_unique<PieceRays>();
  rays->u.slope.fill(0), rays->v.slope.fill(0);
  for (size_t r = 0; r < piece_rays; ++r) {
    const auto i = static_cast<double>(r % piece_edge), j = static_cast<double>(r / piece_edge);
    rays->u.low[r] = -0.37 + 0.53 * i + 0.011 * j, rays->v.low[r] = -0.21 + 0.017 * i + 0.33 * j;
  }
  std::array<uint64_t, piece_rays> layers{};
  const uint64_t any = find_layers(args, *rays, layers);
  uint64_t expected = 0;
  for (int r = 0; r < static_cast<int>(piece_rays); ++r) {
    const double u = rays->u.low[r], v = rays->v.low[r];
    if (u < 0 || v < 0 || u >= blocks_u || v >= blocks_v) continue;
    const int at_u = static_cast<int>(block_edge * u), at_v = static_cast<int>(block_edge * v);
    const uint64_t word = bits[at_v / block_edge * blocks_u + at_u / block_edge];
    uint64_t passed = 0;
    for (int l = 0; l < block_edge; ++l)
      passed |= (word >> (16 * l + 4 * (at_v % block_edge) + at_u % block_edge) & 1) << l;
    if (passed == 0) continue;
    expected |= uint64_t{1} << r;
    EXPECT_EQ(layers[r], passed) << r;
  }
  EXPECT_EQ(any, expected);
  EXPECT_NE(expected, 0u);
}

} // namespace
} // namespace bccsplat
