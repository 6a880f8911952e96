// SPDX-License-Identifier: Apache-2.0
// A box of a time slice: what is made for it, and that it is the whole slice in there, bit for bit.
#include "slice/part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <tuple>

#include "base/error.h"
#include "field/evaluate.h"
#include "kernel/cc_kernel.h"
#include "slice/hyperslice.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::large_cache;
using test::TestContext;

class Part : public testing::TestWithParam<LatticeKind> {
 protected:
  TestContext context;
  Lattice4 lattice = Lattice4::fit(GetParam(), {50, 150, 90, 14}, {1, 1.2, 0.9, 1.1}, 0, {0, 4, 0});
  MemorySamples samples =
      test::sample_field(lattice, test::in_lattice_units(lattice, test::PlaneWaves{9, 0.6, 5}));
  Kernel kernel = lattice.space.bcc ? make_kernel("default") : make_cc_kernel("exact").kernel;
  IndexBox box{{20, 70.5, 0}, {33, 81, 12.25}};

  Slice slice(const HypersliceOptions& options, const BrickBox& region) {
    const Coefficients coefficients(samples, 0, kernel, 0, large_cache, region);
    return hyperslice(coefficients, {0, 0, 0, 1, -6.3}, options, {}, context.get());
  }
  // Points of the box in lattice units of its slice, its corners among them.
  [[nodiscard]] std::vector<Vec3> points(const Slice& slice) const {
    std::mt19937 random(3);
    std::vector<Vec3> list;
    for (int i = 0; i < 3000; ++i) {
      Vec3 p;
      for (size_t a = 0; a < 3; ++a) {
        const double at = i < 8 ? i >> a & 1 : std::uniform_real_distribution<double>(0, 1)(random);
        p[a] = slice.domain_begin[a] + at * (slice.domain_end[a] - slice.domain_begin[a]);
      }
      list.push_back(p);
    }
    return list;
  }
  struct Field {
    std::vector<float> values;
    std::vector<std::array<float, 3>> gradients;
    bool operator==(const Field&) const = default;
  };
  static Field field(const Slice& slice, const std::vector<Vec3>& at) {
    Field f{std::vector<float>(at.size()), std::vector<std::array<float, 3>>(at.size())};
    const EvaluateMisses misses = evaluate(slice, at, f.values, f.gradients);
    EXPECT_EQ(misses.outside + misses.holes, 0u);
    return f;
  }
};

TEST_P(Part, IsTheWholeSliceInItsBox) {
  HypersliceOptions in_box;
  in_box.box = box;
  const BrickBox region = in_box.reads(lattice, kernel);
  const Slice part = slice(in_box, region), whole = slice({}, {});
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(part.lattice_to_slice.point(part.domain_begin)[a], box.begin[a], 1e-12);
    EXPECT_NEAR(part.lattice_to_slice.point(part.domain_end)[a], box.end[a], 1e-12);
  }
  const auto at = points(part);
  EXPECT_EQ(field(part, at), field(whole, at));
  // Of that part alone there are bricks.
  uint64_t bricks = 0, all = 0;
  for (size_t c = 0; c < 2; ++c) bricks += part.coset[c].bricks(), all += whole.coset[c].bricks();
  EXPECT_GT(bricks, 0u);
  EXPECT_LT(bricks * 4, all);
  for (size_t c = 0; c < static_cast<size_t>(lattice.space.cosets()); ++c)
    for (size_t s = 0; s < part.coset[c].brick_slots(); ++s)
      EXPECT_TRUE(!part.coset[c].brick(s) || region.contains(part.coset[c].slot_position(s)));
  const Vec3 outside = part.domain_end + Vec3{0.1, 0, 0};
  EXPECT_FALSE(part.inside(outside));
  EXPECT_TRUE(whole.inside(outside));
}

// What a brick less would leave out is seen.
TEST_P(Part, NeedsTheBricksItAsksFor) {
  HypersliceOptions in_box;
  in_box.box = IndexBox{{20, 70.5, 0}, {33, 110, 12.25}};
  BrickBox region = in_box.reads(lattice, kernel);
  const auto at = points(slice(in_box, region));
  const Field right = field(slice(in_box, region), at);
  region.begin[1] += 2;
  EXPECT_FALSE(field(slice(in_box, region), at) == right);
}

// A maximum is filtered again at its sites: to what the filter's tails are worth.
TEST_P(Part, HoldsTheMaximumOfAThickness) {
  HypersliceOptions in_box, everywhere;
  in_box.box = box;
  in_box.thickness = everywhere.thickness = {2, ThicknessKind::maximum};
  const BrickBox region = in_box.reads(lattice, kernel);
  const Slice part = slice(in_box, region), whole = slice(everywhere, {});
  const auto at = points(part);
  const Field a = field(part, at), b = field(whole, at);
  for (size_t i = 0; i < at.size(); ++i) ASSERT_NEAR(a.values[i], b.values[i], 1e-5);
}

TEST_P(Part, BelongsToTimeSlices) {
  HypersliceOptions options;
  options.box = box;
  const Coefficients coefficients(samples, 0, kernel, 0, large_cache);
  for (const Hyperplane& h : {Hyperplane{1, 0, 0, 0, -9}, Hyperplane{1, 0, 0, 1, -9}})
    EXPECT_THROW((void)hyperslice(coefficients, h, options, {}, context.get()), Error);
  options.method = SliceMethod::resampled;
  EXPECT_THROW((void)hyperslice(coefficients, {0, 0, 0, 1, -6}, options, {}, context.get()), Error);
}

INSTANTIATE_TEST_SUITE_P(Lattices, Part, testing::Values(LatticeKind::d4star, LatticeKind::cc),
                         [](const auto& kind) { return kind.param == LatticeKind::cc ? "cc" : "d4star"; });

// Values alone, under each kernel on each lattice: a box of few sites that goes through all places in a
// brick.
class PartOfValues : public testing::TestWithParam<std::tuple<LatticeKind, std::string>> {};

TEST_P(PartOfValues, NeedsTheReachOfItsKernel) {
  const auto& [kind, name] = GetParam();
  TestContext context;
  const bool moves = kind != LatticeKind::bcc;
  const Lattice4 lattice =
      Lattice4::fit(kind, {62, 66, 58, moves ? 3u : 1u}, {1, 1.1, 0.95, 1}, 0, {2, 0, 4});
  const MemorySamples samples =
      test::sample_field(lattice, test::in_lattice_units(lattice, test::PlaneWaves{5, 0.6, 7}));
  const Kernel kernel = make_kernel(name);
  const int reach = sites_in_reach(lattice, kernel);
  EXPECT_LE(reach, 3);
  const auto cut = [&](const HypersliceOptions& options, const BrickBox& region) {
    const Coefficients coefficients(samples, 0, kernel, 0, large_cache, region);
    return hyperslice(coefficients, {0, 0, 0, 1, moves ? -1.7 : 0.0}, options, {}, context.get());
  };
  const auto values_at = [](const Slice& slice, const std::vector<Vec3>& at) {
    std::vector<float> values(at.size());
    std::vector<std::array<float, 3>> gradients(at.size());
    (void)evaluate(slice, at, values, gradients);
    return std::pair(values, gradients);
  };
  const Slice whole = cut({}, {});
  const double width = lattice.space.bcc ? 2 : 1; // of a site, in planes
  bool less_differs = false;
  for (int n = 0; n < brick_edge; ++n) {
    HypersliceOptions in_box;
    IndexBox& box = in_box.box.emplace();
    for (size_t a = 0; a < 3; ++a) {
      box.begin[a] = (18 + n * width) * lattice.space_step[a];
      box.end[a] = box.begin[a] + (n % 3) * lattice.space_step[a];
    }
    const Slice part = cut(in_box, bricks_around(box, lattice, reach));
    std::vector<Vec3> at;
    for (int i = 0; i < 64; ++i) {
      Vec3 p;
      for (size_t a = 0; a < 3; ++a)
        p[a] = part.domain_begin[a] + (i >> (2 * a) & 3) / 3.0 * (part.domain_end[a] - part.domain_begin[a]);
      at.push_back(p);
    }
    EXPECT_EQ(values_at(part, at), values_at(whole, at)) << n;
    less_differs = less_differs ||
                   values_at(cut(in_box, bricks_around(box, lattice, reach - 2)), at) != values_at(whole, at);
  }
  // Without a prefilter samples are taken as memory has them, all of them.
  EXPECT_EQ(less_differs, !kernel.prefilter4.empty());
}

const auto name_of_values = [](const auto& of) {
  std::string name = std::get<1>(of.param);
  std::replace(name.begin(), name.end(), '+', '_');
  return (std::get<0>(of.param) == LatticeKind::d4star ? "d4star_" : "") + name;
};
INSTANTIATE_TEST_SUITE_P(Bcc, PartOfValues,
                         testing::Combine(testing::Values(LatticeKind::d4star, LatticeKind::bcc),
                                          testing::Values("fast", "default", "fine", "paper", "gauss09",
                                                          "radial18+b4")),
                         name_of_values);
INSTANTIATE_TEST_SUITE_P(Cc, PartOfValues,
                         testing::Combine(testing::Values(LatticeKind::cc),
                                          testing::Values("fast", "default", "exact", "paper",
                                                          "radial18+b4")),
                         name_of_values);

TEST(PartBox, IsClippedToTheSamples) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {10, 20, 30, 8});
  const IndexBox all = clip_to_samples({{-5, -5, -5}, {100, 100, 100}}, lattice);
  EXPECT_EQ(all.begin, (Vec3{0, 0, 0}));
  EXPECT_EQ(all.end, (Vec3{9, 19, 29}));
  EXPECT_THROW((void)clip_to_samples({{0, 20, 0}, {5, 25, 5}}, lattice), Error);
  EXPECT_THROW((void)clip_to_samples({{-2, 0, 0}, {-1, 5, 5}}, lattice), Error);
}

} // namespace
} // namespace bccsplat
