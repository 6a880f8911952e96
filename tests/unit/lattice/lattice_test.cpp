// SPDX-License-Identifier: Apache-2.0
// The lattices against what they are by definition: their generators, duals, densities and neighbours (Conway
// & Sloane, Sphere Packings, ch. 4; Neophytou & Mueller 2002, section 3).
#include "lattice/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace bccsplat {
namespace {

using Numbers = std::array<int, 4>; // of planes along x, y, z, and of the layer

// All sites that a lattice counts, coset by coset.
std::vector<Numbers> sites_of(const Lattice4& lattice) {
  std::vector<Numbers> sites;
  for (int layer = 0; layer < lattice.layers(); ++layer) {
    const int coset = lattice.coset(layer);
    const Int3 n = lattice.space.dims(coset);
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i)
          sites.push_back({lattice.space.plane(coset, i), lattice.space.plane(coset, j),
                           lattice.space.plane(coset, k), layer});
  }
  return sites;
}

// The columns of a generator, in units of a plane: 2 along each axis but the last, which is the shift to the
// other coset. In lattice units they are 1/sqrt2 of that.
using Matrix = std::array<std::array<double, 4>, 4>; // [column][row]
constexpr Matrix d4star{{{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}, {1, 1, 1, 1}}};
// Its dual, D4: V with U^T V = I.
constexpr Matrix d4{{{0.5, 0, 0, -0.5}, {0, 0.5, 0, -0.5}, {0, 0, 0.5, -0.5}, {0, 0, 0, 1}}};

double dot(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

TEST(Lattice, SitesAreWhatTheGeneratorMakes) {
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = 0; j < 4; ++j) ASSERT_EQ(dot(d4star[i], d4[j]), i == j ? 1 : 0) << i << j;
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {7, 6, 8, 5});
  const std::vector<Numbers> sites = sites_of(lattice);
  const std::set<Numbers> known(sites.begin(), sites.end());
  EXPECT_EQ(known.size(), sites.size());
  // Every site is a whole combination of the generator's columns ...
  for (const Numbers& s : sites)
    for (const auto& v : d4) {
      const double n = dot(v, {double(s[0]), double(s[1]), double(s[2]), double(s[3])});
      EXPECT_EQ(n, std::round(n));
    }
  // ... and every such combination within the domain a site.
  const Int3 last = lattice.space.last;
  size_t made = 0;
  for (int d = 0; d <= lattice.last_layer; ++d)
    for (int c = -20; c <= 20; ++c)
      for (int b = -20; b <= 20; ++b)
        for (int a = -20; a <= 20; ++a) {
          const Numbers s{2 * a + d, 2 * b + d, 2 * c + d, d};
          if (s[0] < 0 || s[1] < 0 || s[2] < 0 || s[0] > last[0] || s[1] > last[1] || s[2] > last[2])
            continue;
          ++made;
          EXPECT_TRUE(known.contains(s)) << s[0] << ' ' << s[1] << ' ' << s[2] << ' ' << s[3];
        }
  EXPECT_EQ(made, sites.size());
}

// Sites per volume of one lattice unit to the fourth, or third: of a box so large that its faces count
// little.
double density(LatticeKind kind, uint32_t frames) {
  const Lattice4 lattice = Lattice4::fit(kind, {33, 33, 33, frames});
  double volume = 1;
  for (const int last : lattice.space.last) volume *= (last + 1) * lattice.space.plane_distance();
  if (!lattice.is_static()) volume *= lattice.layers() * lattice.layer_distance();
  return static_cast<double>(sites_of(lattice).size()) / volume;
}

TEST(Lattice, DensitiesAreAHalfAndOneOverRootTwo) {
  EXPECT_NEAR(density(LatticeKind::d4star, 33), 0.5, 2e-3);
  EXPECT_NEAR(density(LatticeKind::bcc, 1), 1 / std::sqrt(2), 2e-3);
  EXPECT_NEAR(density(LatticeKind::cc, 33), 1, 1e-12);
  EXPECT_NEAR(density(LatticeKind::cc, 1), 1, 1e-12);
}

// Sites by their squared distance from one in the middle, in lattice units.
std::vector<std::pair<double, int>> neighbours(LatticeKind kind, uint32_t frames) {
  const Lattice4 lattice = Lattice4::fit(kind, {9, 9, 9, frames});
  const std::vector<Numbers> sites = sites_of(lattice);
  const double in_space = lattice.space.plane_distance(), in_time = lattice.layer_distance();
  const auto even = [](int n) { return n / 2 / 2 * 2; };
  const Numbers middle{even(lattice.space.last[0]), even(lattice.space.last[1]), even(lattice.space.last[2]),
                       lattice.is_static() ? 0 : even(lattice.last_layer)};
  std::map<double, int> counts;
  for (const Numbers& s : sites) {
    double square = 0;
    for (size_t a = 0; a < 4; ++a) {
      if (a == 3 && lattice.is_static()) continue;
      square += std::pow((s[a] - middle[a]) * (a == 3 ? in_time : in_space), 2);
    }
    ++counts[std::round(square * 1e6) / 1e6];
  }
  EXPECT_EQ(counts[0], 1);
  counts.erase(0);
  return {counts.begin(), counts.end()};
}

TEST(Lattice, D4StarHas24NeighboursAndBcc14) {
  const auto d4star_counts = neighbours(LatticeKind::d4star, 9), bcc_counts = neighbours(LatticeKind::bcc, 1);
  EXPECT_EQ(d4star_counts[0], std::pair(2.0, 24));
  EXPECT_EQ(bcc_counts[0], std::pair(1.5, 8));
  EXPECT_EQ(bcc_counts[1], std::pair(2.0, 6));
  EXPECT_EQ(neighbours(LatticeKind::cc, 9)[0], std::pair(1.0, 8));
}

// Frequencies f at which sampling repeats the spectrum: f x is whole for every site x. The nearest are 1
// away, as on the Cartesian grid of pitch 1: the same ball of frequencies fits between them, by half the
// sites.
TEST(Lattice, RepeatedSpectraAreAsFarApartAsTheGrids) {
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {7, 7, 7, 7});
  const double in_space = lattice.space.plane_distance(), in_time = lattice.layer_distance();
  const std::vector<Numbers> sites = sites_of(lattice);
  std::map<double, int> repeats; // by their distance from 0
  constexpr int reach = 3;       // in steps of 1/sqrt8, which hold the dual of any lattice of such planes
  const double step = 1 / std::sqrt(8);
  for (int a = -reach; a <= reach; ++a)
    for (int b = -reach; b <= reach; ++b)
      for (int c = -reach; c <= reach; ++c)
        for (int d = -reach; d <= reach; ++d) {
          const bool whole = std::all_of(sites.begin(), sites.end(), [&](const Numbers& s) {
            const double turns = step * ((a * s[0] + b * s[1] + c * s[2]) * in_space + d * s[3] * in_time);
            return std::fabs(turns - std::round(turns)) < 1e-9;
          });
          if (whole) ++repeats[std::round(std::sqrt(a * a + b * b + c * c + d * d) * step * 1e6) / 1e6];
        }
  ASSERT_GE(repeats.size(), 2u);
  EXPECT_EQ(*repeats.begin(), (std::pair<const double, int>(0, 1)));
  EXPECT_EQ(*std::next(repeats.begin()), (std::pair<const double, int>(1, 24))); // the shortest vectors of D4
}

} // namespace
} // namespace bccsplat
