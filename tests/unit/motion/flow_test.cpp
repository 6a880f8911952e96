// SPDX-License-Identifier: Apache-2.0
// Flow between frames of blobs whose motion is known, the gate that trusts it, and moments along it.
#include "motion/flow.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "motion/finder.h"
#include "tests/bench/motion/dense_moment.h"

namespace bccsplat::motion {
namespace {

constexpr int32_t edge = 48;

Box box_of(const std::function<double(double, double, double)>& value, Int3 dims = {edge, edge, edge}) {
  Box box{dims, {}};
  for (int32_t z = 0; z < dims[2]; ++z)
    for (int32_t y = 0; y < dims[1]; ++y)
      for (int32_t x = 0; x < dims[0]; ++x) box.values.push_back(static_cast<float>(value(x, y, z)));
  return box;
}

Box blob(double x0, double y0, double z0) {
  return box_of([&](double x, double y, double z) {
    return std::exp(-(std::pow(x - x0, 2) + std::pow(y - y0, 2) + std::pow(z - z0, 2)) / 50);
  });
}

double rms(const Box& a, const Box& b) {
  double squares = 0;
  for (size_t i = 0; i < a.values.size(); ++i) squares += std::pow(double{a.values[i]} - b.values[i], 2);
  return std::sqrt(squares / static_cast<double>(a.values.size()));
}

TEST(Flow, HalvedFrameHasEverySecondSampleOfARamp) {
  const Box ramp = box_of([](double x, double y, double z) { return x + 2 * y - z; });
  const Box half = halved(ramp, 1);
  EXPECT_EQ(half.dims, (Int3{edge, edge / 2, edge}));
  EXPECT_NEAR(half.values[half.index(9, 7, 5)], ramp.values[ramp.index(9, 14, 5)], 1e-5);
}

TEST(Flow, PyramidLeavesShortAxesAsTheyAre) {
  const auto levels = make_pyramid(box_of([](double, double, double) { return 0; }, {64, 64, 10}));
  EXPECT_EQ(levels[0].factor, (Int3{4, 4, 1}));
  EXPECT_EQ(levels[0].box.dims, (Int3{16, 16, 10}));
}

TEST(Flow, SplineGoesThroughSamplesAndKnowsItsGradient) {
  const Box box = box_of([](double x, double y, double z) { return std::sin(.5 * x + .3 * y - .4 * z); });
  const Spline spline(box);
  EXPECT_NEAR(spline.value({11, 0, 47}), box.values[box.index(11, 0, 47)], 1e-5);
  EXPECT_NEAR(spline.value({20.5f, 21.25f, 22}), std::sin(.5 * 20.5 + .3 * 21.25 - .4 * 22), 1e-3);
  Float3 gradient;
  const float value = spline.value_and_gradient({20.3f, 21.6f, 22.5f}, gradient);
  EXPECT_NEAR(value, spline.value({20.3f, 21.6f, 22.5f}), 1e-6);
  const double slope = std::cos(.5 * 20.3 + .3 * 21.6 - .4 * 22.5);
  EXPECT_NEAR(gradient[0], .5 * slope, 3e-3);
  EXPECT_NEAR(gradient[1], .3 * slope, 3e-3);
  EXPECT_NEAR(gradient[2], -.4 * slope, 3e-3);
  EXPECT_EQ(spline.value({-3, 5, 60}), spline.value({0, 5, 47}));
}

TEST(Flow, BlobThatMovesHasItsShiftHalfway) {
  const Flow flow = find_flow(Sketch(blob(20, 22, 24)), Sketch(blob(26.5, 19, 25)));
  const Float3 v = flow.at({23.25f, 20.5f, 24.5f});
  EXPECT_NEAR(v[0], 6.5, .1);
  EXPECT_NEAR(v[1], -3, .1);
  EXPECT_NEAR(v[2], 1, .1);
}

TEST(Flow, WhatStandsHasNone) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  Box frame = blob(20, 22, 24);
  for (float& v : frame.values) v += .05f * static_cast<float>(noise(random));
  for (const Float3& v : find_flow(Sketch(frame), Sketch(frame)).velocity)
    EXPECT_LT(std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]), 1e-3);
}

TEST(Flow, NothingToSeeIsNoMotion) {
  const Box empty = box_of([](double, double, double) { return 7; });
  for (const Float3& v : find_flow(Sketch(empty), Sketch(empty)).velocity) EXPECT_EQ(v, Float3{});
}

TEST(Flow, CubicSharesMeetFramesAndLeaveFarOnesOut) {
  const std::vector<double> times{0, 1, 2, 3, 30};
  const auto middle = cubic_shares(times, 1.5);
  ASSERT_EQ(middle.size(), 4u);
  EXPECT_FLOAT_EQ(middle[0].weight, -1.f / 16);
  EXPECT_FLOAT_EQ(middle[1].weight, 9.f / 16);
  EXPECT_FLOAT_EQ(middle[3].ahead, 1.5);
  EXPECT_EQ(cubic_shares(times, .5).size(), 3u);  // none before the first
  EXPECT_EQ(cubic_shares(times, 2.5).size(), 3u); // frame 4 is far away
  for (const Share& s : cubic_shares(times, 2)) EXPECT_FLOAT_EQ(s.weight, s.frame == 2 ? 1 : 0);
}

Finder finder_of(const std::function<Box(double)>& at, size_t count) {
  std::vector<double> times;
  for (size_t t = 0; t < count; ++t) times.push_back(static_cast<double>(t));
  Finder finder(times);
  for (size_t t = 0; t < count; ++t) finder.give(t, at(static_cast<double>(t)));
  return finder;
}

TEST(Flow, MomentFollowsABlob) {
  const auto at = [](double t) { return blob(8 + 6 * t, 36 - 3 * t, 24); };
  Finder finder = finder_of(at, 6);
  const Box truth = at(2.4);
  Box still{truth.dims, std::vector<float>(truth.values.size())};
  const std::vector<Share> shares = cubic_shares(finder.times(), 2.4);
  for (const Share& s : shares) {
    const Box frame = at(static_cast<double>(s.frame));
    for (size_t i = 0; i < still.values.size(); ++i) still.values[i] += s.weight * frame.values[i];
  }
  EXPECT_LT(rms(dense_moment(finder, 2.4, still), truth), .1 * rms(still, truth));
}

TEST(Flow, MomentAtAFrameIsTheFrame) {
  const auto at = [](double t) { return blob(8 + 6 * t, 36 - 3 * t, 24); };
  Finder finder = finder_of(at, 6);
  EXPECT_LT(rms(dense_moment(finder, 2, at(2)), at(2)), 1e-6);
}

TEST(Flow, GateIsOffForBlobsOnCircles) {
  const auto at = [](double t) { // one each way round, through each other
    Box sum = blob(24 + 10 * std::cos(.2 * t), 24 + 10 * std::sin(.2 * t), 24);
    const Box other = blob(24 + 10 * std::cos(2.4 - .2 * t), 24 + 10 * std::sin(2.4 - .2 * t), 24);
    for (size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += other.values[i];
    return sum;
  };
  Finder finder = finder_of(at, 7);
  Box still = at(3);
  still.values.assign(still.values.size(), 0);
  for (const Share& s : cubic_shares(finder.times(), 3.5)) {
    const Box frame = at(static_cast<double>(s.frame));
    for (size_t i = 0; i < still.values.size(); ++i) still.values[i] += s.weight * frame.values[i];
  }
  const Box truth = at(3.5);
  EXPECT_GT(rms(dense_moment(finder, 3.5, still, {.gated = false}), truth), 1.2 * rms(still, truth));
  EXPECT_LT(rms(dense_moment(finder, 3.5, still), truth), 1.02 * rms(still, truth));
}

TEST(Flow, MaskOffLeavesAMomentBitForBit) {
  const Box a = blob(20, 22, 24), b = blob(26, 22, 24);
  const Flow flow = find_flow(Sketch(a), Sketch(b));
  const Spline first(a), second(b);
  const std::vector<const Spline*> frames{&first, &second};
  const std::vector<float> off(flow.nodes.count());
  const Ways ways(flow, frames, linear_shares(std::vector<double>{0, 1}, .5), 0);
  EXPECT_EQ(sum_along(ways, flow, off, a).values, a.values);
  EXPECT_NE(sum_along(ways, flow, {}, a).values, a.values);
}

TEST(Flow, WayOfOneVelocityIsTheShiftedSpline) {
  const Spline frame(blob(20, 22, 24));
  Flow flow{nodes_over({edge, edge, edge}, 16), {}};
  flow.velocity.assign(flow.nodes.count(), {5.5f, -2.25f, 1});
  const std::vector<const Spline*> frames{&frame, &frame};
  const std::vector<Share> first_alone{{0, 1, -.4f}, {1, 0, .6f}};
  const Ways ways(flow, frames, first_alone, .1f);
  for (const Float3& p : {Float3{20, 21, 22}, Float3{24.5f, 18, 30.25f}, Float3{1, 46, 3}})
    EXPECT_NEAR(ways.value(p, flow.at(p)), frame.value({p[0] - 2.2f, p[1] + .9f, p[2] - .4f}), 1e-5);
}

TEST(Flow, StillFramesHaveNoMask) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise;
  const std::vector<double> times{0, 1, 2, 3, 4};
  Finder finder(times), noisy(times);
  for (size_t t = 0; t < 5; ++t) {
    Box frame = blob(20, 22, 24);
    finder.give(t, frame);
    for (float& v : frame.values) v += .05f * static_cast<float>(noise(random));
    noisy.give(t, frame);
  }
  for (Finder* f : {&finder, &noisy})
    for (const float m : f->interval(2)->mask) EXPECT_EQ(m, 0);
}

TEST(Flow, IntervalTellsWhatItLacksAndIsFoundOnce) {
  const auto at = [](double t) { return blob(8 + 4 * t, 24, 24); };
  Finder finder({0, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(finder.lacks(0), (std::vector<size_t>{0, 1, 2, 4})); // what is made of frame 1 left out, too
  EXPECT_EQ(finder.lacks(3), (std::vector<size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  for (const size_t f : finder.lacks(3)) finder.give(f, at(static_cast<double>(f)));
  const auto found = finder.interval(3);
  EXPECT_TRUE(finder.lacks(3).empty());
  EXPECT_EQ(finder.interval(3), found);
  finder.keep(3, 2, 1);
  EXPECT_EQ(finder.frames_held(), 2u);
  EXPECT_EQ(finder.interval(3), found);
  Finder uneven({0, 1, 30, 31}); // no frame can be left out
  EXPECT_EQ(uneven.lacks(1), (std::vector<size_t>{1, 2}));
}

} // namespace
} // namespace bccsplat::motion
