// SPDX-License-Identifier: Apache-2.0
// The loops of rays in lanes beside one ray at a time: roots between samples, and layers of cells, for any
// number of rays, whole vectors or not.
#include "splat/rays/ray_roots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "splat/rays/ray_lanes.h"
#include "splat/shade/surface.h"
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
    pairs.push_back({low - 5.0 * ray, 5, end(a), end(b), static_cast<uint32_t>(pairs.size())});
  }
  return pairs;
}

TEST(RayRoots, AreWhereTheFieldIsTheTargetForAnyNumber) {
  const Slice s = test::make_slice({30, 30, 30}, [](double x, double y, double z) {
    return 0.5 + 0.4 * std::sin(0.5 * x) * std::cos(0.4 * y + 0.3 * z);
  });
  const SurfaceField field(s);
  const Vec3 ray{0.5, 0.3, -0.7};
  const float target = 0.55f - static_cast<float>(s.base);
  const std::vector<RootPair> all = pairs_of(field, ray, target, 70);
  const auto roots = std::make_unique<RayRoots>(field.footprints, ray, target);
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

// Rays through a slab of blocks, straight along it: each passes the column of cells that it stands in.
TEST(RayLayers, AreThoseOfTheBlockThatARayPasses) {
  constexpr int blocks_u = 3, blocks_v = 2;
  std::mt19937_64 random(11);
  std::array<uint64_t, blocks_u * blocks_v> bits;
  for (uint64_t& word : bits) word = random() & random();
  SlabArgs::Masks mask_u{}, mask_v{};
  for (size_t n = 0; n < mask_u.size(); ++n)
    for (uint64_t bit = 0; bit < 64; ++bit) {
      const int cell = static_cast<int>(n) / SlabArgs::parts - block_edge;
      if (static_cast<int>(bit & 3) == cell) mask_u[n] |= uint64_t{1} << bit;
      if (static_cast<int>(bit >> 2 & 3) == cell) mask_v[n] |= uint64_t{1} << bit;
    }
  SlabArgs args;
  args.bits = bits.data();
  for (size_t bit = 0; bit < 64; ++bit) args.layer[bit >> 4] |= uint64_t{1} << bit;
  // Part of the rays lie before the first block or behind the last one.
  args.u = {blocks_u, 1, &mask_u, -0.37, 0.53, 0.011};
  args.v = {blocks_v, blocks_u, &mask_v, -0.21, 0.017, 0.33};
  std::array<uint64_t, piece_rays> layers{};
  const uint64_t any = find_layers(args, layers);
  uint64_t expected = 0;
  for (int r = 0; r < static_cast<int>(piece_rays); ++r) {
    const int i = r % piece_edge, j = r / piece_edge;
    const double u = -0.37 + 0.53 * i + 0.011 * j, v = -0.21 + 0.017 * i + 0.33 * j;
    if (u < 0 || v < 0 || u >= blocks_u || v >= blocks_v) continue;
    const int at_u = static_cast<int>(block_edge * u), at_v = static_cast<int>(block_edge * v);
    const uint64_t word = bits[static_cast<size_t>(at_v / block_edge * blocks_u + at_u / block_edge)];
    uint64_t passed = 0;
    for (int l = 0; l < block_edge; ++l)
      passed |= (word >> (16 * l + 4 * (at_v % block_edge) + at_u % block_edge) & 1) << l;
    if (passed == 0) continue;
    expected |= uint64_t{1} << r;
    EXPECT_EQ(layers[static_cast<size_t>(r)], passed) << r;
  }
  EXPECT_EQ(any, expected);
  EXPECT_NE(expected, 0u);
}

} // namespace
} // namespace bccsplat
