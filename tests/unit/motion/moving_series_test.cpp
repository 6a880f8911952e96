// SPDX-License-Identifier: Apache-2.0
// Moments of series on lattices that follow blobs whose motion is known.
#include "motion/moving_series.h"

#include <array>
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "field/sample_grid.h"
#include "slice/hyperslice.h"
#include "tests/support/fields.h"

namespace bccsplat::motion {
namespace {

using test::large_cache;
using test::TestContext;

constexpr int32_t side = 40, depth = 96, frames = 8;

double blob(const Vec4& p, double speed) {
  const double x = p[0] - 6 - speed * p[3], y = p[1] - 32 + .6 * speed * p[3], z = p[2] - 20;
  return std::exp(-(x * x + y * y + z * z) / 18);
}

// A blob that moves by some samples a frame, beside one that stands.
struct Series {
  Lattice4 lattice;
  MemorySamples samples;
  Coefficients coefficients;
  TimeAxis times;
  MovingSeries moving;

  static double value(const Vec4& p, double speed) {
    const double x = p[0] - 33, y = p[1] - 33, z = p[2] - depth + 8;
    const double v = blob(p, speed) + std::exp(-(x * x + y * y + z * z) / 18);
    return v < 1e-6 ? 0 : v;
  }
  // Between frames its samples are blends of these. layers: of time, a frame.
  static double blended(const Vec4& p, double speed) {
    const double before = std::floor(p[3]), share = p[3] - before;
    return (1 - share) * value({p[0], p[1], p[2], before}, speed) +
           share * value({p[0], p[1], p[2], before + 1}, speed);
  }
  explicit Series(LatticeKind kind, double speed = 4, double layers = 1)
      : lattice(Lattice4::fit(kind, {side, side, depth, frames}, {1, 1, 1, 1 / layers})),
        samples(test::sample_field(lattice, [speed](const Vec4& p) { return blended(p, speed); })),
        coefficients(samples, 0, make_kernel("default"), 1e-7f, large_cache), times(0, 1, frames),
        moving(coefficients, times) {}

  Slice moment(double at, const Context& context, bool follows) const {
    const FollowMoment follow = [this](Slice& m, const Context& with) { moving.follow(m, with); };
    return make_slice(plan_moment(coefficients, at, {0, 0}, {}), {}, context,
                      follows ? follow : FollowMoment{});
  }
};

std::vector<float> values_of(const Slice& slice, const Context& context) {
  std::vector<float> values(static_cast<size_t>(side) * side * depth);
  sample_grid(slice, {{}, {1, 1, 1}, {side, side, depth}}, values.data(), context);
  return values;
}

double rms(const std::vector<float>& values, double at, double speed) {
  double squares = 0;
  size_t i = 0;
  for (int32_t z = 0; z < depth; ++z)
    for (int32_t y = 0; y < side; ++y)
      for (int32_t x = 0; x < side; ++x)
        squares += std::pow(values[i++] - Series::value({double(x), double(y), double(z), at}, speed), 2);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

// A moment that follows is what the frames are: where layers of time are as far apart as frames, D4* holds
// these no better than moments.
TEST(MovingSeries, MomentFollowsABlob) {
  TestContext context;
  const Context with = context.get();
  const Series cartesian(LatticeKind::cc), finer(LatticeKind::d4star, 4, 2.5);
  for (const Series* series : {&cartesian, &finer}) {
    const auto error = [&](double at, bool follows) {
      return rms(values_of(series->moment(at, with, follows), with), at, 4);
    };
    const double before = error(3.5, false), after = error(3.5, true), frame = error(3, false);
    EXPECT_LT(after, .4 * before);
    EXPECT_LT(after, 1.5 * frame);
  }
}

TEST(MovingSeries, FrameAndWhatStandsStayBitForBit) {
  TestContext context;
  const Context with = context.get();
  const Series series(LatticeKind::cc);
  EXPECT_EQ(values_of(series.moment(3, with, true), with), values_of(series.moment(3, with, false), with));
  EXPECT_TRUE(series.moving.frames_of(3).empty());
  const Series still(LatticeKind::cc, 0);
  EXPECT_EQ(values_of(still.moment(3.5, with, true), with), values_of(still.moment(3.5, with, false), with));
}

TEST(MovingSeries, BricksThatDoNotFollowAreTheSame) {
  TestContext context;
  const Context with = context.get();
  const Series series(LatticeKind::cc);
  const Slice still = series.moment(3.5, with, false), moved = series.moment(3.5, with, true);
  size_t same = 0, others = 0;
  for (size_t s = 0; s < still.coset[0].brick_slots(); ++s) {
    const Brick *a = still.coset[0].brick(s), *b = moved.coset[0].brick(s);
    if (a || b) (a && b && a->value == b->value ? same : others)++;
  }
  EXPECT_GT(same, 0u); // the blob that stands
  EXPECT_GT(others, 0u);
}

TEST(MovingSeries, MissingDataShowNoMotion) {
  TestContext context;
  const Context with = context.get();
  const Series whole(LatticeKind::cc);
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < whole.lattice.layers(); ++m) {
    BrickLayer layer = whole.samples.read_layer(0, m, {}, with);
    auto brick = std::make_shared<Brick>(); // one corner is missing in every frame, by another value
    brick->value.fill(static_cast<float>(m)), brick->kept.fill(0xffff);
    brick->hole = std::make_unique<BrickMask>();
    brick->hole->fill(0xffff);
    layer.set(layer.slot(2, 2, 2), std::move(brick));
    layers.push_back(std::move(layer));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  const MemorySamples samples(whole.lattice, {0}, std::move(channels));
  const Coefficients coefficients(samples, 0, make_kernel("default"), 1e-7f, large_cache);
  const MovingSeries moving(coefficients, TimeAxis(0, 1, frames));
  const Slice moved = make_slice(plan_moment(coefficients, 3.5, {0, 0}, {}), {}, with,
                                 [&](Slice& m, const Context& c) { moving.follow(m, c); });
  const std::vector<float> values = values_of(moved, with),
                           of_whole = values_of(whole.moment(3.5, with, true), with);
  size_t missing = 0;
  double squares = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const bool near = i / side % side >= 28 && i / side / side >= 28 && i % side >= 28;
    missing += std::isnan(values[i]);
    if (!near) squares += std::pow(values[i] - of_whole[i], 2);
  }
  EXPECT_GT(missing, 0u);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(values.size())), 2e-3);
}

TEST(MovingSeries, ThreadsFindTheSame) {
  const Series series(LatticeKind::cc);
  TestContext context;
  const Context with = context.get();
  const std::vector<double> at{2.25, 3.5, 4.75};
  std::vector<std::vector<float>> expected;
  for (const double t : at) expected.push_back(values_of(series.moment(t, with, true), with));
  const Series fresh(LatticeKind::cc);
  std::array<std::vector<std::vector<float>>, 2> made;
  const auto walk = [&](size_t which) { // one forwards, one backwards
    TestContext own;
    for (size_t i = 0; i < at.size(); ++i)
      made[which].push_back(
          values_of(fresh.moment(at[which ? at.size() - 1 - i : i], own.get(), true), own.get()));
  };
  std::thread other(walk, 1);
  walk(0);
  other.join();
  for (size_t i = 0; i < at.size(); ++i) {
    EXPECT_EQ(made[0][i], expected[i]);
    EXPECT_EQ(made[1][at.size() - 1 - i], expected[i]);
  }
}

TEST(MovingSeries, IntervalIsFoundOnceWithinTheBudget) {
  TestContext context;
  const Series series(LatticeKind::cc);
  const Context with = context.get();
  const size_t lacking = series.moving.frames_of(3.5).size();
  series.moving.prepare(3.5, with);
  EXPECT_EQ(lacking, 8u);
  EXPECT_EQ(series.moving.frames_of(3.25).size(), 4u);
  EXPECT_GT(context.memory.used(), 0u);
  TestContext small(2, 1000);
  const Series other(LatticeKind::cc);
  EXPECT_THROW(other.moving.prepare(3.5, small.get()), Error);
  EXPECT_EQ(small.memory.used(), 0u);
}

} // namespace
} // namespace bccsplat::motion
