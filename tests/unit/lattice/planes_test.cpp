// SPDX-License-Identifier: Apache-2.0
// How many planes and layers there are for a distance, with faces, ends and turns, and which of them stands
// for one beyond.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/error.h"
#include "lattice/lattice.h"

namespace bccsplat {
namespace {

using Kind = LatticeKind;
using Dims = std::array<uint32_t, 4>;

Lattice4 turning(Kind kind, const Dims& dims, double scale) {
  return Lattice4::fit(kind, dims, {scale, scale, scale, 1}, 0, {0, 0, 0}, false, {true, true, true});
}
Lattice4 periodic(Kind kind, const Dims& dims, double scale) {
  return Lattice4::fit(kind, dims, {1, 1, 1, scale}, 0, {0, 0, 0}, true);
}

TEST(LatticePlanes, AreAsManyAsTheDistanceAsksFor) {
  const Lattice4 cubic = Lattice4::fit(Kind::cc, {5, 1, 3, 1}, {1, 1, 0.7, 1});
  EXPECT_EQ(cubic.space.last, (Int3{4, 1, 3}));
  EXPECT_EQ(cubic.space_step, (Vec3{1, 1, 2.0 / 3}));
  EXPECT_EQ(Lattice4::fit(Kind::cc, {7, 7, 7, 1}, {2 - 1e-11, 2, 1, 1}).space.last, (Int3{3, 3, 6}));
  const Lattice4 centred = Lattice4::fit(Kind::bcc, {5, 5, 9, 1}, {1, 1, 2, 1}, 0, {2, 4, 6});
  EXPECT_EQ(centred.space.last, (Int3{6 + 4, 6 + 8, 6 + 12}));
  EXPECT_EQ(centred.space_step, (Vec3{4.0 / 6, 4.0 / 6, 8.0 / 6}));
  EXPECT_EQ(centred.before, (Int3{2, 4, 6}));
  EXPECT_EQ(centred.behind, centred.before);
}

TEST(LatticePlanes, OfTurningAxesAreAWholeTurn) {
  EXPECT_EQ(turning(Kind::cc, {6, 7, 8, 1}, 1).space.last, (Int3{5, 6, 7}));
  EXPECT_EQ(turning(Kind::cc, {6, 7, 8, 1}, 1).space_step, (Vec3{1, 1, 1}));
  EXPECT_EQ(turning(Kind::bcc, {6, 7, 8, 1}, 1).space.last, (Int3{9, 9, 11}));
  EXPECT_EQ(turning(Kind::bcc, {6, 7, 8, 1}, 1).space_step, (Vec3{0.6, 0.7, 8.0 / 12}));
  for (const auto kind : {Kind::cc, Kind::bcc}) {
    const Lattice4 least = turning(kind, {2, 2, 2, 1}, 8);
    EXPECT_EQ(least.space.last, (Int3{1, 1, 1}));
    EXPECT_EQ(least.space_step, (Vec3{1, 1, 1}));
    EXPECT_EQ(least.space.periodic, (AxisFlags{true, true, true}));
  }
}

TEST(LatticePlanes, LayersAreAWholeTurnOfAPeriodicSeries) {
  EXPECT_EQ(Lattice4::fit(Kind::cc, {3, 3, 3, 1}).last_layer, 0);
  const Lattice4 still = Lattice4::fit(Kind::d4star, {3, 3, 3, 1});
  EXPECT_EQ(std::pair(still.kind, still.last_layer), std::pair(Kind::bcc, 1));
  const Lattice4 series = Lattice4::fit(Kind::bcc, {3, 3, 3, 5}, {1, 1, 1, 1}, 4);
  EXPECT_EQ(std::pair(series.kind, series.last_layer), std::pair(Kind::d4star, 6 + 8));
  EXPECT_FALSE(series.periodic);
  const std::vector<std::array<double, 5>> cases{// D4*?, frames, distance, layers, step
                                                 {0, 5, 1, 5, 1},
                                                 {0, 5, 10, 2, 2.5},
                                                 {1, 6, 1, 10, 0.6},
                                                 {1, 5, 10, 2, 2.5}};
  for (const auto& [four, frames, distance, layers, step] : cases) {
    const Lattice4 l =
        periodic(four != 0 ? Kind::d4star : Kind::cc, {3, 3, 3, static_cast<uint32_t>(frames)}, distance);
    EXPECT_TRUE(l.periodic);
    EXPECT_EQ(l.layers(), layers);
    EXPECT_EQ(l.time_step, step);
  }
}

TEST(LatticePlanes, WhatCannotBeIsRefused) {
  EXPECT_THROW(Lattice4::fit(Kind::cc, {5, 5, 0, 1}), Error);
  for (const double scale : {0.0, -1.0, 65537.0, std::nan("")})
    for (size_t a = 0; a < 4; ++a) {
      LatticeScales scales{1, 1, 1, 1};
      scales[a] = scale;
      EXPECT_THROW(Lattice4::fit(Kind::cc, {5, 5, 5, 5}, scales), Error) << scale << ' ' << a;
    }
  EXPECT_NO_THROW(Lattice4::fit(Kind::cc, {5, 5, 5, 5}, {65536, 65536, 65536, 65536}));
  EXPECT_THROW(Lattice4::fit(Kind::cc, {5, 5, 5, 1}, {1, 1, 1e-9, 1}), Error);
  EXPECT_THROW(turning(Kind::cc, {5, 1, 5, 1}, 1), Error);
  EXPECT_NO_THROW(turning(Kind::cc, {2, 2, 2, 1}, 1));
  EXPECT_THROW(Lattice4::fit(Kind::cc, {5, 5, 5, 1}, {1, 1, 1, 1}, 0, {0, 2, 0}, false, {false, true, false}),
               Error);
}

TEST(LatticePlanes, BeyondFacesAndEndsAreMirroredOrTurned) {
  const Lattice4 cubic = Lattice4::fit(Kind::cc, {5, 5, 5, 5}),
                 centred = Lattice4::fit(Kind::d4star, {5, 5, 5, 5});
  const auto mirrored = [](const Lattice4& l, int coset, std::vector<int> sites) {
    for (int& i : sites) i = l.space.mirror(2, coset, i);
    return sites;
  };
  EXPECT_EQ(mirrored(cubic, 0, {-5, -1, 0, 4, 5, 9}), (std::vector<int>{3, 1, 0, 4, 3, 1}));
  EXPECT_EQ(mirrored(centred, 0, {-1, 0, 3, 4, 5}), (std::vector<int>{1, 0, 3, 2, 1}));
  EXPECT_EQ(mirrored(centred, 1, {-2, -1, 0, 2, 3}), (std::vector<int>{1, 0, 0, 2, 2}));
  EXPECT_EQ(mirrored(turning(Kind::cc, {5, 5, 6, 1}, 1), 0, {-7, -6, -1, 5, 6, 7}),
            (std::vector<int>{5, 0, 5, 5, 0, 1}));
  EXPECT_EQ(mirrored(turning(Kind::bcc, {5, 5, 6, 1}, 1), 1, {-1, 4, 5}), (std::vector<int>{4, 4, 0}));

  const auto layers = [](const Lattice4& l) {
    return std::array{l.mirror_layer(-1), l.mirror_layer(l.last_layer), l.mirror_layer(l.layers())};
  };
  EXPECT_EQ(layers(cubic), (std::array{1, 4, 3}));
  EXPECT_EQ(layers(centred), (std::array{1, 6, 5}));
  EXPECT_EQ(layers(periodic(Kind::cc, {3, 3, 3, 5}, 1)), (std::array{4, 4, 0}));
  EXPECT_EQ(layers(Lattice4::fit(Kind::bcc, {3, 3, 3, 1})), (std::array{1, 1, 0}));
  EXPECT_EQ(layers(Lattice4::fit(Kind::cc, {3, 3, 3, 1})), (std::array{0, 0, 0}));

  const auto frames = [](const Lattice4& l) {
    return std::array{l.nearest_frame(-1), l.nearest_frame(2.4), l.nearest_frame(2.5), l.nearest_frame(5)};
  };
  EXPECT_EQ(frames(cubic), (std::array<int64_t, 4>{0, 2, 3, 4}));
  EXPECT_EQ(frames(periodic(Kind::cc, {3, 3, 3, 5}, 1)), (std::array<int64_t, 4>{4, 2, 3, 0}));
}

// A distance a little below 1 is 1 where a whole number of planes asked for it, and itself where that number
// is one too large for 1.
TEST(LatticePlanes, NominalDistancesAreThoseThatWereAskedFor) {
  const auto nominal = [](const Lattice4& l) { return l.nominal_scales(); };
  EXPECT_EQ(nominal(Lattice4::fit(Kind::d4star, {5, 6, 7, 5}, {1, 1, 1, 2})),
            (LatticeScales{1, 1, 1, Lattice4::fit(Kind::d4star, {5, 6, 7, 5}, {1, 1, 1, 2}).scales()[3]}));
  EXPECT_EQ(nominal(Lattice4::fit(Kind::cc, {8, 8, 8, 1}, {0.9999, 0.9999, 2, 1})),
            (LatticeScales{0.875, 0.875, 1.75, 0}));
  EXPECT_EQ(nominal(Lattice4::fit(Kind::bcc, {5, 5, 5, 1}, {1, 1, 1, 1}, 0, {2, 2, 2})),
            (LatticeScales{1, 1, 1, 0}));
  EXPECT_EQ(nominal(turning(Kind::bcc, {6, 7, 8, 1}, 1)), (LatticeScales{1, 1, 1, 0}));
  const Lattice4 fine = Lattice4::fit(Kind::bcc, {101, 101, 101, 1}, {0.8, 0.8, 0.8, 1});
  EXPECT_EQ(fine.nominal_scales(), fine.scales());
  EXPECT_EQ(nominal(periodic(Kind::d4star, {3, 3, 3, 6}, 1))[3], 1);
  EXPECT_EQ(nominal(periodic(Kind::cc, {3, 3, 3, 7}, 0.9999))[3], 0.875);
  EXPECT_EQ(nominal(periodic(Kind::cc, {3, 3, 3, 7}, 1))[3], 1);
  const Lattice4 slow = periodic(Kind::cc, {3, 3, 3, 8}, 4),
                 quick = periodic(Kind::d4star, {3, 3, 3, 40}, 0.5);
  EXPECT_EQ(slow.nominal_scales(), slow.scales());
  EXPECT_EQ(quick.nominal_scales()[3], quick.scales()[3]);
}

TEST(LatticePlanes, SitesAreCountedWithinAndOutside) {
  for (const auto kind : {Kind::cc, Kind::d4star}) {
    const Lattice4 l = Lattice4::fit(kind, {5, 4, 7, 3}, {1, 1, 1, 1}, 2, {2, 4, 6});
    int64_t all = 0, outside = 0;
    for (int32_t m = 0; m < l.layers(); ++m) {
      const Int3 n = l.space.dims(l.coset(m));
      for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
          for (int i = 0; i < n[0]; ++i) {
            const Vec3 p = l.site_position(l.coset(m), {i, j, k});
            bool inside = true;
            for (size_t a = 0; a < 3; ++a) inside = inside && p[a] > -1e-9 && p[a] < l.dims[a] - 1 + 1e-9;
            ++all;
            outside += m >= 1 && !inside ? 1 : 0;
          }
    }
    EXPECT_EQ(l.sites(), all);
    EXPECT_EQ(l.sites_outside(1, l.layers()), outside);
    EXPECT_GT(outside, 0);
  }
}

TEST(LatticePlanes, SitesAreSamplesAtDistanceOneAlone) {
  EXPECT_TRUE(Lattice4::fit(Kind::cc, {5, 4, 3, 2}).sites_are_samples());
  EXPECT_TRUE(Lattice4::fit(Kind::cc, {5, 1, 3, 1}, {1, 2, 1, 1}).sites_are_samples());
  EXPECT_FALSE(Lattice4::fit(Kind::cc, {5, 4, 3, 3}, {1, 1, 1, 2}).sites_are_samples());
  EXPECT_FALSE(Lattice4::fit(Kind::cc, {5, 4, 3, 1}, {1, 1, 1, 1}, 0, {0, 0, 1}).sites_are_samples());
  EXPECT_FALSE(Lattice4::fit(Kind::bcc, {5, 4, 3, 1}, {std::sqrt(2.0), std::sqrt(2.0), std::sqrt(2.0), 1})
                   .sites_are_samples());
  for (size_t a = 0; a < 3; ++a) {
    LatticeScales scales{1, 1, 1, 1};
    scales[a] = 0.5;
    EXPECT_FALSE(Lattice4::fit(Kind::cc, {5, 4, 3, 2}, scales).sites_are_samples()) << a;
  }
}

TEST(LatticePlanes, TheMeanDistanceIsGeometric) {
  EXPECT_EQ(mean_in_space({0.7, 0.7, 0.7, 5}), 0.7);
  for (const LatticeScales& s : {LatticeScales{1, 2, 4, 9}, {1, 1, 8, 9}, {8, 1, 1, 9}, {1, 8, 1, 9}})
    EXPECT_NEAR(mean_in_space(s), 2, 1e-12);
}

} // namespace
} // namespace bccsplat
