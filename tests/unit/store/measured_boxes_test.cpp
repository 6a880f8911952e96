// SPDX-License-Identifier: Apache-2.0
// Boxes of frames that are compared with the file: where they are, what they need and what they stand for.
#include "store/measured_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "field/sample_grid.h"
#include "slice/time_slice.h"
#include "tests/unit/store/written_series.h"

namespace bccsplat {
namespace {

using test::Bench;
using test::noise;
using test::Opened;
using test::Series;

// The boxes of one frame of a series.
std::vector<MeasuredBox> choose(const Lattice4& lattice, uint32_t frame, const Series& series) {
  const FrameBox box = series.box(0);
  return choose_measured_boxes(lattice, frame, {&box, 1}, 0);
}

Series waves(const std::array<uint32_t, 4>& dims) {
  return Series(dims, [](double x, double y, double z, double t) {
    return std::sin(0.7 * x + 0.2 * t) + std::cos(0.5 * y) + std::sin(0.6 * z);
  });
}

double sum_of_weights(std::span<const MeasuredBox> boxes) {
  double sum = 0;
  for (const MeasuredBox& b : boxes) sum += b.weight;
  return sum;
}

std::vector<float> sampled(const Slice& slice, const Region& region, const Context& context) {
  Grid grid;
  for (size_t a = 0; a < 3; ++a) {
    grid.origin[a] = static_cast<double>(region.begin[a]);
    grid.dims[a] = static_cast<int32_t>(region.length(a));
  }
  std::vector<float> values(region.samples());
  sample_grid(slice, grid, values.data(), context);
  return values;
}

// The law of a box: nothing outside its bricks counts.
void expect_same_field(WriterSettings settings, const Series& series) {
  settings.dims = series.dims;
  std::vector<std::byte> bytes;
  (void)test::write(settings, series, bytes);
  Opened file(std::move(bytes));
  const uint32_t frame = series.dims[3] / 2;
  const Context context = file.bench.context;
  const Slice whole = time_slice(*file.coefficients, frame, {0, 0}, {}, context);
  std::set<std::array<int64_t, 3>> seen;
  for (uint32_t number = 0; number < 8; ++number)
    for (const MeasuredBox& box : choose(file.lattice(), number, series)) {
      ASSERT_FALSE(box.is_whole());
      if (!seen.insert(box.samples.begin).second) continue;
      const Coefficients part(file.samples, 0, file.coefficients->kernel(), 0, 64 << 20, box.bricks);
      const Slice slice = time_slice(part, frame, {0, 0}, {}, context);
      EXPECT_EQ(sampled(slice, box.samples, context), sampled(whole, box.samples, context));
    }
  EXPECT_GT(seen.size(), 4u);
}

TEST(MeasuredBoxes, FieldDependsOnTheirBricksAlone) {
  expect_same_field({}, noise({118, 76, 76, 4}, 1));
  WriterSettings cartesian;
  cartesian.lattice = LatticeKind::cc, cartesian.scales = {1, 1, 1, 2};
  expect_same_field(cartesian, noise({84, 52, 52, 4}, 2));
  WriterSettings still;
  still.recommended_kernel = "paper";
  expect_same_field(still, noise({118, 76, 76, 1}, 3));
}

TEST(MeasuredBoxes, FieldThatGoesRound) {
  WriterSettings turning;
  turning.turning = {true, false, false};
  expect_same_field(turning, noise({118, 76, 76, 3}, 4));
}

TEST(MeasuredBoxes, SpreadOverTheFrame) {
  const std::array<uint32_t, 4> dims{160, 120, 100, 9};
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, dims);
  const Series series = noise({160, 120, 100, 1}, 5);
  std::vector<bool> seen(series.values.size());
  std::set<std::array<int64_t, 3>> begins;
  for (uint32_t frame = 0; frame < 40; ++frame) {
    const std::vector<MeasuredBox> boxes = choose(lattice, frame, series);
    EXPECT_NEAR(sum_of_weights(boxes), 1, 0.02) << "what fills a frame evenly is all of it";
    uint64_t samples = 0;
    for (const MeasuredBox& box : boxes) {
      const Region& in = box.samples;
      samples += in.samples();
      for (size_t a = 0; a < 3; ++a) {
        EXPECT_GE(in.begin[a], 0);
        EXPECT_LE(in.end[a], dims[a]);
        EXPECT_GE(in.length(a), 8);
      }
      if (!begins.insert(in.begin).second) continue;
      for (int64_t z = in.begin[2]; z < in.end[2]; ++z)
        for (int64_t y = in.begin[1]; y < in.end[1]; ++y)
          std::fill_n(seen.begin() + (z * 120 + y) * 160 + in.begin[0], in.length(0), true);
    }
    EXPECT_LE(samples, series.values.size() * 2 / 5) << "a part of the frame";
  }
  // Boxes of one division take half of the frame.
  const auto covered = std::count(seen.begin(), seen.end(), true);
  EXPECT_GT(static_cast<double>(covered), 0.65 * static_cast<double>(seen.size())) << "all parts have a turn";
}

// A sum over the boxes of a frame, which stands for the mean of the frame.
template<class Value> double weighed(std::span<const MeasuredBox> boxes, const Value& value) {
  double mean = 0;
  for (const MeasuredBox& b : boxes) {
    double sum = 0;
    for (int64_t z = b.samples.begin[2]; z < b.samples.end[2]; ++z)
      for (int64_t y = b.samples.begin[1]; y < b.samples.end[1]; ++y)
        for (int64_t x = b.samples.begin[0]; x < b.samples.end[0]; ++x) sum += value(x, y, z);
    mean += b.weight * sum / static_cast<double>(b.samples.samples());
  }
  return mean;
}

// Noise everywhere, and in a slab at x = 80 to 90 another one in each frame.
TEST(MeasuredBoxes, LookWhereSomethingMoves) {
  constexpr int64_t edge = 128;
  const Series still = noise({edge, edge, edge, 1}, 9), moving = noise({edge, edge, edge, 3}, 10);
  Series series({edge, edge, edge, 3}, [&](double x, double y, double z, double t) {
    const auto at = [&](const Series& s, double frame) {
      return s.at(static_cast<int64_t>(x), static_cast<int64_t>(y), static_cast<int64_t>(z),
                  static_cast<int64_t>(frame));
    };
    return x >= 80 && x < 90 ? at(moving, t) : at(still, 0);
  });
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {edge, edge, edge, 9});
  const auto bend = [&](int64_t x, int64_t y, int64_t z) {
    const auto v = [&](int64_t t) { return static_cast<double>(series.at(x, y, z, t)); };
    return (v(2) - 2 * v(1) + v(0)) * (v(2) - 2 * v(1) + v(0));
  };
  const double truth = weighed(std::vector{whole_frame(lattice)}, bend);
  double known = 0, unknown = 0; // mean distances from the truth
  constexpr uint32_t tries = 8;
  MemoryBudget memory;
  for (uint32_t number = 2; number < 2 + tries; ++number) {
    EarlierFrames earlier({edge, edge, edge}, 0, memory);
    for (uint32_t t = 0; t < 2; ++t) {
      const FrameBox box = series.box(t);
      earlier.see(number - 2 + t, {&box, 1});
    }
    const FrameBox box = series.box(2);
    const auto with = choose_measured_boxes(lattice, number, {&box, 1}, 0, &earlier);
    const auto without = choose_measured_boxes(lattice, number, {&box, 1}, 0);
    known += std::fabs(weighed(with, bend) / truth - 1) / tries;
    unknown += std::fabs(weighed(without, bend) / truth - 1) / tries;
  }
  EXPECT_LT(known, 0.05);
  EXPECT_GT(unknown, 0.2) << "what moves is not seen in one frame";
}

TEST(EarlierFrames, LetExpectThatThingsGoOn) {
  const Series series({5, 3, 9, 4}, [](double x, double y, double z, double t) {
    return 10 + x + 2 * y + 4 * z + t * (1 + x) * 8;
  });
  MemoryBudget memory;
  EarlierFrames earlier({5, 3, 9}, 10, memory);
  const auto see = [&](uint32_t number, uint32_t frame) {
    const FrameBox box = series.box(frame);
    earlier.see(number, {&box, 1});
  };
  EXPECT_FALSE(earlier.knows(0));
  see(4, 0);
  EXPECT_TRUE(earlier.knows(5));
  EXPECT_FALSE(earlier.knows(6));
  const auto expect_plane = [&](int64_t z, double frame) {
    const std::span<const float> plane = earlier.expect(z);
    ASSERT_EQ(plane.size(), 15u);
    for (size_t i = 0; i < plane.size(); ++i) {
      const auto x = static_cast<double>(i % 5), y = static_cast<double>(i / 5);
      EXPECT_EQ(plane[i], x + 2 * y + 4 * static_cast<double>(z) + frame * (1 + x) * 8) << i;
    }
  };
  expect_plane(2, 0); // of one frame: as it is
  see(5, 1);
  expect_plane(2, 2), expect_plane(6, 2);
  see(6, 2);
  expect_plane(6, 3);
  see(9, 3);
  EXPECT_FALSE(earlier.knows(7));
  EXPECT_TRUE(earlier.knows(10));
  expect_plane(2, 3); // nothing is known of the frames between
}

TEST(MeasuredBoxes, DependOnTheFrameAlone) {
  const Series series = noise({128, 128, 100, 1}, 6);
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {128, 128, 100, 7});
  const auto begins = [&](uint32_t frame, const Series& of) {
    std::vector<std::array<int64_t, 3>> list;
    for (const MeasuredBox& b : choose(lattice, frame, of)) list.push_back(b.samples.begin);
    return list;
  };
  EXPECT_EQ(begins(3, series), begins(3, Series(series)));
  EXPECT_NE(begins(3, series), begins(4, series)) << "another frame has other boxes";
  // Frames in pieces are the same frames.
  const FrameBox whole = series.box(0);
  FrameBox low = whole, high = whole;
  low.dims[2] = 40, high.begin[2] = 40, high.dims[2] = 60;
  high.data = series.values.data() + 40 * 128 * 128;
  const std::array<FrameBox, 2> pieces{low, high};
  const auto of_pieces = choose_measured_boxes(lattice, 3, pieces, 0);
  const auto of_whole = choose_measured_boxes(lattice, 3, {&whole, 1}, 0);
  ASSERT_EQ(of_pieces.size(), of_whole.size());
  for (size_t i = 0; i < of_whole.size(); ++i) EXPECT_EQ(of_pieces[i].weight, of_whole[i].weight);
}

TEST(MeasuredBoxes, SmallFramesAreWhole) {
  for (const std::array<uint32_t, 4>& dims :
       {std::array<uint32_t, 4>{1, 1, 1, 1}, {7, 1, 3, 5}, {64, 64, 64, 3}, {96, 96, 96, 2}}) {
    const Series series = noise({dims[0], dims[1], dims[2], 1}, 7);
    const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, dims);
    const std::vector<MeasuredBox> boxes = choose(lattice, 0, series);
    ASSERT_EQ(boxes.size(), 1u);
    EXPECT_TRUE(boxes.front().is_whole());
    EXPECT_EQ(boxes.front().samples.samples(), series.values.size());
    EXPECT_EQ(boxes.front().weight, 1);
  }
}

// What fills an eighth of a frame stands for an eighth of it, and is where boxes are.
TEST(MeasuredBoxes, LookWhereSomethingIs) {
  Series series = noise({128, 128, 128, 1}, 8);
  for (size_t i = 0; i < series.values.size(); ++i)
    if (i % 128 >= 64 || i / 128 % 128 >= 64 || i / 128 / 128 >= 64) series.values[i] = 0;
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {128, 128, 128, 9});
  for (uint32_t frame = 0; frame < 9; ++frame) {
    double filled = 0, squares = 0;
    for (const MeasuredBox& b : choose(lattice, frame, series)) {
      double own = 0, sum = 0;
      for (int64_t z = b.samples.begin[2]; z < b.samples.end[2]; ++z)
        for (int64_t y = b.samples.begin[1]; y < b.samples.end[1]; ++y)
          for (int64_t x = b.samples.begin[0]; x < b.samples.end[0]; ++x) {
            const double v = series.at(x, y, z, 0);
            own += v != 0 ? 1 : 0, sum += v * v;
          }
      filled += b.weight * own / static_cast<double>(b.samples.samples());
      squares += b.weight * sum / static_cast<double>(b.samples.samples());
    }
    EXPECT_NEAR(filled, 1.0 / 8, 0.01) << frame;
    EXPECT_NEAR(squares, 1.0 / 24, 0.004) << frame;
  }
}

TEST(MeasuredBoxes, NothingToSee) {
  const Lattice4 lattice = Lattice4::fit(LatticeKind::d4star, {128, 128, 128, 9});
  for (const float value : {0.0f, std::numeric_limits<float>::quiet_NaN()}) {
    const Series series({128, 128, 128, 1}, [&](double, double, double, double) { return value; });
    const std::vector<MeasuredBox> boxes = choose(lattice, 1, series);
    EXPECT_FALSE(boxes.empty());
    EXPECT_TRUE(std::isfinite(sum_of_weights(boxes)));
  }
  EXPECT_FALSE(choose_measured_boxes(lattice, 1, {}, 5).empty()) << "no boxes: all is air";
}

TEST(MeasuredBoxes, ErrorsOfTheFrame) {
  SampleErrors quiet, loud;
  for (int i = 0; i < 10; ++i) quiet.all.add(1), quiet.bare.add(1), quiet.non_air.add(1);
  for (int i = 0; i < 30; ++i) loud.all.add(-3), loud.bare.add(-3);
  loud.non_air.add(5), loud.lost = 2;
  BoxErrors boxes;
  boxes.add(quiet, 0.25), boxes.add(loud, 0.5);
  const SampleErrors e = boxes.of_frame();
  EXPECT_EQ(e.all.count, 40u);
  EXPECT_EQ(e.all.largest, 3);
  EXPECT_EQ(e.lost, 2u);
  EXPECT_NEAR(e.all.rms(), std::sqrt(0.25 * 1 + 0.5 * 9), 1e-12);
  EXPECT_NEAR(e.bare.rms(), e.all.rms(), 1e-12);
  // Samples that are not air: 0.25 of the frame in one box, 0.5 / 30 of it in the other.
  EXPECT_NEAR(e.non_air.rms(), std::sqrt((0.25 * 1 + 0.5 / 30 * 25) / (0.25 + 0.5 / 30)), 1e-12);
}

// Three frames of a series are not gone through again: a share of them is.
TEST(MeasuredBoxes, WriterComparesAShare) {
  const Series series = waves({128, 128, 128, 3});
  const auto measured = [&](Measure measure) {
    Bench bench(2);
    WriterSettings settings;
    settings.dims = series.dims, settings.measure = measure;
    std::vector<std::byte> bytes;
    VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
    for (uint32_t t = 0; t < 3; ++t) {
      const FrameBox box = series.box(t);
      writer.add_frame(0, t, {&box, 1});
    }
    (void)writer.finish();
    return writer.measured(0, -1).errors.all;
  };
  const ErrorSum all = measured(Measure::all), some = measured(Measure::some);
  EXPECT_EQ(all.count, series.values.size());
  EXPECT_GT(some.count, series.values.size() / 20);
  EXPECT_LT(some.count, series.values.size() / 3);
  EXPECT_NEAR(some.rms(), all.rms(), 0.06 * all.rms());
  EXPECT_LE(some.largest, all.largest);
}

} // namespace
} // namespace bccsplat
