// SPDX-License-Identifier: Apache-2.0
// Predictions of what lies outside the faces: their weights, and how bold they are.
#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "fit/axis/site_axis.h"
#include "fit/beyond/ends.h"
#include "fit/beyond/face_noise.h"
#include "fit/beyond/face_table.h"

namespace bccsplat {
namespace {

Lattice4 lattice_with_margins(LatticeKind kind = LatticeKind::d4star) {
  return Lattice4::fit(kind, {50, 40, 60, 9}, {1, 1.3, .8, 1}, 0, {2, 2, 2});
}

TEST(FaceTable, TakesNoSampleFromOutside) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const Lattice4 lattice = lattice_with_margins(kind);
    for (size_t axis = 0; axis < 3; ++axis)
      for (int c = 0; c < lattice.space.cosets(); ++c) {
        const double widening = std::max(1.0, lattice.space_step[axis] / lattice.space.plane_distance());
        const FilterTable table = face_table(lattice, c, axis, widening, 1e-3);
        const auto positions = site_positions(lattice, c, axis);
        const FilterTable plain = filter_table(widening, positions);
        ASSERT_EQ(table.first.size(), positions.size());
        for (size_t i = 0; i < positions.size(); ++i) {
          const size_t taps = table.taps;
          const auto row = std::span(table.weight).subspan(i * taps, taps);
          EXPECT_NEAR(std::accumulate(row.begin(), row.end(), 0.0), 1, 1e-5);
          EXPECT_GE(table.first[i], 0);
          EXPECT_LE(table.first[i] + table.taps, lattice.dims[axis]);
          if (plain.first[i] < 0 || plain.first[i] + plain.taps > lattice.dims[axis]) continue;
          // Away from the faces nothing changes.
          for (int k = 0; k < plain.taps; ++k) {
            const int64_t sample = plain.first[i] + k;
            EXPECT_EQ(table.weight[i * taps + (sample - table.first[i])], plain.weight[i * plain.taps + k]);
          }
        }
      }
  }
}

// What the planes outside hold of a slow wave: it, but for the outermost of two on BCC, which makes up for
// the mirrors.
TEST(FaceTable, PredictsASlowWave) {
  const auto wave = [](double x) { return std::cos(.3 * x + .5); };
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const Lattice4 lattice = lattice_with_margins(kind);
    const double h = lattice.space_step[0];
    for (int c = 0; c < lattice.space.cosets(); ++c) {
      const FilterTable table = face_table(lattice, c, 0, 1, 1e-5);
      const auto positions = site_positions(lattice, c, 0);
      for (size_t i = 0; i < positions.size(); ++i) {
        double sum = 0, want = wave(positions[i]);
        for (int k = 0; k < table.taps; ++k)
          sum += table.weight[i * table.taps + k] * wave(static_cast<double>(table.first[i] + k));
        const double out = std::max(-positions[i], positions[i] - 49), side = positions[i] < 0 ? -1 : 1;
        if (lattice.space.bcc && out > 1.5 * h) {
          const double face = positions[i] < 0 ? 0 : 49;
          const auto outside = [&](int planes) { return wave(face + side * planes * h); };
          want += .25 * (outside(0) - outside(1) + outside(3) - outside(4));
        }
        EXPECT_NEAR(sum, want, out > 0 ? .04 * out : .003) << positions[i];
      }
    }
  }
}

std::vector<float> values_of(const std::array<int64_t, 3>& n, const std::function<double(int, int, int)>& f) {
  std::vector<float> values;
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) values.push_back(static_cast<float>(f(x, y, z)));
  return values;
}

FaceLevels levels_of(const std::vector<float>& values) {
  FrameBox box;
  box.data = values.data();
  box.dims = {50, 40, 60};
  return choose_face_levels(Frame({&box, 1}, {50, 40, 60}, 0, "frame"), lattice_with_margins());
}

// As bold as the data allow, axis by axis.
TEST(FaceNoise, FollowsTheData) {
  const std::array<int64_t, 3> n{50, 40, 60};
  EXPECT_EQ(levels_of(values_of(n, [](int, int, int) { return 0; })), usual_face_levels);
  const auto smooth = [](int x, int y, int z) { return std::sin(.4 * x + .3 * y - .35 * z); };
  for (const uint8_t level : levels_of(values_of(n, smooth))) EXPECT_LE(end_noises[level], 1e-4);
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const uint8_t level : levels_of(values_of(n, [&](int, int, int) { return normal(random); })))
    EXPECT_GE(end_noises[level], 1e-1);
  // Planes that have nothing to do with each other along z alone.
  std::vector<double> planes(60);
  for (double& v : planes) v = normal(random);
  const FaceLevels mixed =
      levels_of(values_of(n, [&](int x, int y, int z) { return std::sin(.4 * x + .3 * y) * planes[z]; }));
  EXPECT_LE(end_noises[mixed[0]], 1e-4);
  EXPECT_LE(end_noises[mixed[1]], 1e-4);
  EXPECT_GE(end_noises[mixed[2]], 1e-2);
}

// The host's rounding mode changes nothing that counts.
TEST(EndFrames, AreMadeInAnyRoundingMode) {
  EndFrames usual(1.3, 3e-5);
  const std::vector<double> want = usual.weights(2, 30);
  std::fesetround(FE_UPWARD);
  EndFrames upward(1.3, 3e-5);
  const std::vector<double> got = upward.weights(2, 30);
  std::fesetround(FE_TONEAREST);
  for (size_t i = 0; i < want.size(); ++i) EXPECT_NEAR(got[i], want[i], 1e-6);
}

} // namespace
} // namespace bccsplat
