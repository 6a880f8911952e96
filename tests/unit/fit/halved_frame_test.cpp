// SPDX-License-Identifier: Apache-2.0
// Halved frames against sums that read like their definition, and what must not change them.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fit/axis/site_axis.h"
#include "fit/resample/halved_frame.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

using Dims = std::array<int64_t, 3>;
constexpr Dims frame_dims{45, 30, 37};

size_t at(const Dims& n, int64_t x, int64_t y, int64_t z) { return (z * n[1] + y) * n[0] + x; }

// Noise around 3 within a ball, 0 outside it; of a radius beyond all corners noise everywhere.
std::vector<float> noise_in_ball(double radius) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> unit(1, 5);
  std::vector<float> values(at(frame_dims, 0, 0, frame_dims[2]));
  for (int64_t z = 0; z < frame_dims[2]; ++z)
    for (int64_t y = 0; y < frame_dims[1]; ++y)
      for (int64_t x = 0; x < frame_dims[0]; ++x) {
        const float v = unit(random);
        const auto off = [&](int64_t i, size_t a) {
          return static_cast<double>(i) - 0.5 * static_cast<double>(frame_dims[a]);
        };
        values[at(frame_dims, x, y, z)] = std::hypot(off(x, 0), off(y, 1), off(z, 2)) < radius ? v : 0;
      }
  return values;
}

HalvedFrame halve(const std::vector<float>& values, std::span<const FrameBox> boxes, int threads,
                  float ringing = 0, const AxisFlags& predicted = {}) {
  Bench bench(threads);
  FrameBox whole;
  whole.data = values.data(), whole.dims = frame_dims;
  const Frame frame(boxes.empty() ? std::span(&whole, 1) : boxes, frame_dims, 0, "frame");
  const FrameScan scan = scan_frame(frame, 0, bench.context);
  FrameHalver halver(frame_dims, {true, true, true}, predicted);
  HalvedFrame made = halver.halve(frame, scan.cells, usual_face_levels, ringing, bench.context);
  made.memory = {}; // of a budget that ends here
  return made;
}

TEST(HalvedFrame, IsTheFilteredFrameAtTwiceTheDistance) {
  const std::vector<float> values = noise_in_ball(1000);
  const HalvedFrame made = halve(values, {}, 2);
  const Dims n = made.frame->dims();
  EXPECT_EQ(n, (Dims{23, 16, 19}));
  std::array<FilterTable, 3> table;
  for (size_t a = 0; a < 3; ++a) {
    const double step = (static_cast<double>(frame_dims[a]) - 1) / (static_cast<double>(n[a]) - 1);
    std::vector<double> positions;
    for (int64_t i = 0; i < n[a]; ++i) positions.push_back(static_cast<double>(i) * step);
    table[a] = filter_table(step, positions);
  }
  for (int64_t z = 0; z < n[2]; z += 6)
    for (int64_t y = 0; y < n[1]; y += 5)
      for (int64_t x = 0; x < n[0]; x += 2) {
        double sum = 0;
        const auto tap = [&](size_t a, int64_t i, int k) {
          const size_t row = i;
          return std::pair(mirror_index(table[a].first[row] + k, frame_dims[a]),
                           static_cast<double>(table[a].weight[row * table[a].taps + k]));
        };
        for (int c = 0; c < table[2].taps; ++c)
          for (int b = 0; b < table[1].taps; ++b)
            for (int a = 0; a < table[0].taps; ++a) {
              const auto [i, u] = tap(0, x, a);
              const auto [j, v] = tap(1, y, b);
              const auto [k, w] = tap(2, z, c);
              sum += u * v * w * values[at(frame_dims, i, j, k)];
            }
        ASSERT_NEAR(made.values[at(n, x, y, z)], sum, 1e-5) << x << " " << y << " " << z;
      }
}

// What is left out because it is air changes nothing, nor do threads and boxes; and the ranges are those of
// the values.
// An axis of one sample stays one, and the others are halved as those of a frame that is the same all along
// it.
TEST(HalvedFrame, OneSampleStaysOne) {
  const std::vector<float> values = noise_in_ball(1000);
  for (size_t thin = 0; thin < 3; ++thin) {
    const auto halved = [&](int64_t samples) {
      Dims n = frame_dims;
      n[thin] = samples;
      std::vector<float> frame_values(at(n, 0, 0, n[2]));
      for (int64_t z = 0; z < n[2]; ++z)
        for (int64_t y = 0; y < n[1]; ++y)
          for (int64_t x = 0; x < n[0]; ++x) {
            Dims from{x, y, z};
            from[thin] = 7;
            frame_values[at(n, x, y, z)] = values[at(frame_dims, from[0], from[1], from[2])];
          }
      Bench bench(2);
      FrameBox whole;
      whole.data = frame_values.data(), whole.dims = n;
      const Frame frame(std::span(&whole, 1), n, 0, "frame");
      const FrameScan scan = scan_frame(frame, 0, bench.context);
      AxisFlags axes{true, true, true};
      axes[thin] = false;
      FrameHalver halver(n, axes, {});
      HalvedFrame made = halver.halve(frame, scan.cells, usual_face_levels, 0, bench.context);
      made.memory = {};
      EXPECT_EQ(made.frame->dims(), halver.dims());
      return std::pair(halver.dims(), std::move(made.values));
    };
    const auto [one_dims, one] = halved(1);
    const auto [many_dims, many] = halved(5);
    EXPECT_EQ(one_dims[thin], 1);
    EXPECT_EQ(many_dims[thin], 5);
    for (int64_t z = 0; z < one_dims[2]; ++z)
      for (int64_t y = 0; y < one_dims[1]; ++y)
        for (int64_t x = 0; x < one_dims[0]; ++x) {
          Dims same{x, y, z};
          same[thin] = 2;
          ASSERT_NEAR(one[at(one_dims, x, y, z)], many[at(many_dims, same[0], same[1], same[2])], 1e-5);
        }
  }
}

TEST(HalvedFrame, IsTheSameHoweverItIsMade) {
  const std::vector<float> values = noise_in_ball(11);
  const HalvedFrame made = halve(values, {}, 1, 1.0f / 512);
  std::vector<FrameBox> boxes;
  for (int64_t z = 0; z < frame_dims[2]; z += 10)
    for (int64_t x = 0; x < frame_dims[0]; x += 9) {
      FrameBox& box = boxes.emplace_back();
      box.begin = {x, 0, z}, box.dims = {9, frame_dims[1], std::min<int64_t>(10, frame_dims[2] - z)};
      box.data = &values[at(frame_dims, x, 0, z)];
      box.stride = {4, 4 * frame_dims[0], 4 * frame_dims[0] * frame_dims[1]};
    }
  EXPECT_EQ(halve(values, {}, 4, 1.0f / 512).values, made.values);
  EXPECT_EQ(halve(values, boxes, 2, 1.0f / 512).values, made.values);

  Bench bench(1);
  const FrameScan scan = scan_frame(*made.frame, 0, bench.context);
  ASSERT_EQ(made.cells.cell.size(), scan.cells.cell.size());
  size_t air = 0;
  for (size_t i = 0; i < made.cells.cell.size(); ++i) {
    EXPECT_EQ(made.cells.cell[i].low, scan.cells.cell[i].low) << i;
    EXPECT_EQ(made.cells.cell[i].high, scan.cells.cell[i].high) << i;
    air += made.cells.cell[i].air() ? 1 : 0;
  }
  EXPECT_GT(air, 0u);
}

// Whether all samples are air that are up to 1.25 distances of a halved frame of n to the sides of one of it.
bool air_around(const std::vector<float>& values, const Dims& n, const Dims& place) {
  std::array<std::array<int64_t, 2>, 3> span;
  for (size_t a = 0; a < 3; ++a) {
    const double step = static_cast<double>(frame_dims[a] - 1) / static_cast<double>(n[a] - 1);
    const double position = static_cast<double>(place[a]) * step;
    span[a] = {std::max<int64_t>(0, static_cast<int64_t>(std::ceil(position - 1.25 * step))),
               std::min(frame_dims[a] - 1, static_cast<int64_t>(std::floor(position + 1.25 * step)))};
  }
  for (int64_t z = span[2][0]; z <= span[2][1]; ++z)
    for (int64_t y = span[1][0]; y <= span[1][1]; ++y)
      for (int64_t x = span[0][0]; x <= span[0][1]; ++x)
        if (values[at(frame_dims, x, y, z)] != 0) return false;
  return true;
}

// All of what rings where everything around is air, however loud, and nothing but murmurs elsewhere.
// A box, made of the samples that it asks for and no others, is that part of the whole.
TEST(HalvedFrame, ABoxNeedsWhatIsNearAlone) {
  for (const double radius : {14.0, 1000.0}) { // air, and none
    const std::vector<float> values = noise_in_ball(radius);
    Bench bench(2);
    FrameBox whole;
    whole.data = values.data(), whole.dims = frame_dims;
    const auto made_of = [&](const Region* box) {
      FrameHalver halver(frame_dims, {true, true, true}, {true, false, true}, {}, true);
      Frame frame(std::span(&whole, 1), frame_dims, 0, "frame");
      if (box) halver.make_only(*box), frame.set_given(halver.seen());
      const FrameScan scan = scan_frame(frame, 0, bench.context);
      HalvedFrame made = halver.halve(frame, scan.cells, usual_face_levels, 1.0f / 512, bench.context);
      made.memory = {};
      return made;
    };
    const HalvedFrame all = made_of(nullptr);
    const Dims n = all.frame->dims();
    for (const Region& box : {Region{{16, 8, 8}, {23, 16, 19}}, Region{{0, 0, 16}, {16, 8, 19}}}) {
      const HalvedFrame part = made_of(&box);
      EXPECT_EQ(part.frame->given(), box);
      size_t i = 0;
      for (int64_t z = box.begin[2]; z < box.end[2]; ++z)
        for (int64_t y = box.begin[1]; y < box.end[1]; ++y)
          for (int64_t x = box.begin[0]; x < box.end[0]; ++x)
            ASSERT_EQ(part.values[i++], all.values[at(n, x, y, z)]) << x << " " << y << " " << z;
      EXPECT_EQ(part.values.size(), i);
      for (size_t c = 0; c < all.cells.cell.size(); ++c)
        EXPECT_TRUE(part.cells.cell[c].air() || part.cells.cell[c].low == all.cells.cell[c].low) << c;
      EXPECT_EQ(part.cells.range(box).high, all.cells.range(box).high);
    }
  }
}

// Without the least of all samples taken off first a few units in the last place are lost.
TEST(HalvedFrame, WhatVariesLittleLosesNextToNothing) {
  std::vector<float> values = noise_in_ball(1000);
  for (float& v : values) v = 300 + v / 100;
  std::array<std::vector<float>, 2> made;
  for (const bool local : {false, true}) {
    Bench bench(1);
    FrameBox whole;
    whole.data = values.data(), whole.dims = frame_dims;
    const Frame frame(std::span(&whole, 1), frame_dims, 0, "frame");
    const FrameScan scan = scan_frame(frame, 0, bench.context);
    FrameHalver halver(frame_dims, {true, true, true}, {}, {}, local);
    made[local ? 1 : 0] = halver.halve(frame, scan.cells, usual_face_levels, 0, bench.context).values;
  }
  const float unit = std::ldexp(1.0f, -15); // in the last place, of 256 to 512
  float most = 0;
  for (size_t i = 0; i < made[0].size(); ++i) most = std::max(most, std::fabs(made[0][i] - made[1][i]));
  EXPECT_GT(most, 0);
  EXPECT_LE(most, 8 * unit);
}

TEST(HalvedFrame, RingingInAirIsAir) {
  const std::vector<float> values = noise_in_ball(11);
  const HalvedFrame rings = halve(values, {}, 1, 0), clean = halve(values, {}, 1, 1.0f / 512);
  const Dims n = rings.frame->dims();
  size_t dropped = 0, loud = 0;
  for (int64_t z = 0; z < n[2]; ++z)
    for (int64_t y = 0; y < n[1]; ++y)
      for (int64_t x = 0; x < n[0]; ++x) {
        const size_t i = at(n, x, y, z);
        const bool air = air_around(values, n, {x, y, z});
        if (air) {
          ASSERT_EQ(clean.values[i], 0) << x << " " << y << " " << z;
        }
        if (clean.values[i] == rings.values[i]) continue;
        ++dropped;
        EXPECT_EQ(clean.values[i], 0);
        const bool murmur = std::fabs(rings.values[i]) <= 5.0f / 512;
        EXPECT_TRUE(air || murmur);
        loud += murmur ? 0 : 1;
      }
  EXPECT_GT(dropped, 100u);
  EXPECT_GT(loud, 30u);
}

// Along an axis that turns what is around a sample goes on at the other end: a frame that is turned by two
// samples is halved to one that is turned by one.
TEST(HalvedFrame, AirIsFoundBeyondEndsThatTurn) {
  constexpr int64_t n = 44;
  const auto halved = [&](int64_t shift) {
    std::vector<float> values(static_cast<size_t>(n * n * n));
    for (int64_t z = 0; z < n; ++z)
      for (int64_t y = 0; y < n; ++y)
        for (int64_t x = 0; x < n; ++x) {
          const double dx = static_cast<double>((x + shift) % n) - 20, dy = static_cast<double>(y) - 22,
                       dz = static_cast<double>(z) - 22;
          values[(z * n + y) * n + x] = std::hypot(dx, dy, dz) < 9 ? 3.0f : 0.0f;
        }
    Bench bench(1);
    FrameBox whole;
    whole.data = values.data(), whole.dims = {n, n, n};
    const Frame frame(std::span(&whole, 1), whole.dims, 0, "frame");
    const FrameScan scan = scan_frame(frame, 0, bench.context);
    FrameHalver halver({n, n, n}, {true, true, true}, {}, {true, false, false});
    HalvedFrame made = halver.halve(frame, scan.cells, usual_face_levels, 1.0f / 512, bench.context);
    made.memory = {};
    return made;
  };
  const HalvedFrame middle = halved(0), end = halved(22); // the ball lies across the ends
  const Dims m = middle.frame->dims();
  ASSERT_EQ(m[0], 22);
  size_t air = 0;
  for (int64_t z = 0; z < m[2]; ++z)
    for (int64_t y = 0; y < m[1]; ++y)
      for (int64_t x = 0; x < m[0]; ++x) {
        const size_t row = (z * m[1] + y) * m[0];
        const float a = middle.values[row + (x + 11) % m[0]], b = end.values[row + x];
        ASSERT_EQ(a == 0, b == 0) << x << " " << y << " " << z;
        ASSERT_NEAR(a, b, 1e-6f);
        air += a == 0 ? 1 : 0;
      }
  EXPECT_GT(air, middle.values.size() / 2);
}

// A constant stays one, bit for bit; a ramp has no bend at faces beyond which samples are predicted.
TEST(HalvedFrame, ConstantsAndRampsStayWhatTheyAre) {
  for (const float v : halve(std::vector<float>(at(frame_dims, 0, 0, frame_dims[2]), 70.1f), {}, 2).values)
    ASSERT_EQ(v, 70.1f);
  std::vector<float> ramp(at(frame_dims, 0, 0, frame_dims[2]));
  for (size_t i = 0; i < ramp.size(); ++i)
    ramp[i] = 10 + static_cast<float>(i % static_cast<size_t>(frame_dims[0]));
  const auto bend = [&](const AxisFlags& predicted) {
    const HalvedFrame made = halve(ramp, {}, 2, 0, predicted);
    return std::fabs(made.values[0] - 10);
  };
  EXPECT_GT(bend({}), 0.3f);
  EXPECT_LT(bend({true, true, true}), 0.1f);
}

} // namespace
} // namespace bccsplat::test
