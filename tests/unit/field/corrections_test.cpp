// SPDX-License-Identifier: Apache-2.0
// Corrections of files of both kinds against their formula, and the grids that hold them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "field/corrections.h"
#include "field/slice_corrections.h"
#include "formats/bcc4/read/frame_sources.h"
#include "tests/support/larger.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr std::array<uint32_t, 4> dims{70, 9, 68, 4};
constexpr double step = 0.25;

// Steps of some samples on both sides of the faces of bricks.
std::vector<ResidualList> some_samples() {
  std::mt19937 random(11);
  std::vector<ResidualList> frames(dims[3]);
  for (uint32_t f = 0; f < dims[3]; ++f)
    for (uint64_t v = 0; v < uint64_t{dims[0]} * dims[1] * dims[2]; ++v) {
      const uint64_t x = v % dims[0], z = v / (dims[0] * dims[1]);
      const bool near_face = x > 60 && x < 67 && z > 60;
      if (f != 2 && (near_face ? random() % 2 : random() % 50) == 0)
        frames[f].push_back({v, static_cast<int64_t>(random() % 41) - 20});
    }
  return frames;
}

std::shared_ptr<const Bcc4Reader> file_of(const std::vector<ResidualList>& frames, bool local,
                                          CorrectionShape shape) {
  VolumeInfo info = volume(LatticeKind::d4star, dims, {channel("value", ValueType::f32)});
  ResidualInfo& fix = info.channels[0].residuals;
  fix.step = fix.bound = step, fix.local = local, fix.shape = shape;
  std::vector<std::byte> bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  for (uint32_t f = 0; f < dims[3]; ++f) {
    ResidualList set;
    if (f == 1) set = {{5, 3}};
    writer.write_residuals(0, f, {.add = frames[f], .set = set}, bench.context);
  }
  writer.finish(bench.context);
  static std::vector<std::vector<std::byte>> kept; // a reader borrows its bytes
  kept.reserve(16);
  return Bcc4Reader::open(open_memory_source(kept.emplace_back(std::move(bytes))));
}

// The formula of the page, in double.
double expected(const std::vector<ResidualList>& frames, CorrectionShape shape, const Vec4& p) {
  const auto fall = [&](double d) {
    d = std::fabs(d);
    if (d >= 1) return 0.0;
    return shape == CorrectionShape::tent ? 1 - d : (1 - d) * (1 - d) * (1 + 2 * d);
  };
  double sum = 0;
  for (uint32_t f = 0; f < dims[3]; ++f) {
    if (fall(p[3] - f) == 0) continue;
    for (const ResidualSample& s : frames[f]) {
      const auto v = static_cast<double>(s.voxel);
      const double x = std::fmod(v, dims[0]), y = std::fmod(std::floor(v / dims[0]), dims[1]),
                   z = std::floor(v / (dims[0] * dims[1]));
      sum += static_cast<double>(s.steps) * step * fall(p[0] - x) * fall(p[1] - y) * fall(p[2] - z) *
             fall(p[3] - f);
    }
  }
  return sum;
}

TEST(Corrections, AreThoseOfThePageWithBothRecords) {
  const auto frames = some_samples();
  std::mt19937 random(2);
  std::vector<Vec4> points;
  for (int i = 0; i < 150; ++i) {
    Vec4 p;
    for (size_t a = 0; a < 4; ++a) p[a] = std::uniform_real_distribution<double>(0, dims[a] - 1.0)(random);
    if (i % 3 == 0) p[0] = std::uniform_real_distribution<double>(61, 66)(random), p[2] = 62 + p[2] / 20;
    if (i % 10 == 0) p[3] = std::floor(p[3]);
    points.push_back(p);
  }
  for (const auto& [local, shape] : {std::pair(false, CorrectionShape::tent),
                                     {true, CorrectionShape::tent},
                                     {true, CorrectionShape::smooth}}) {
    for (const uint64_t cache : {uint64_t{1} << 20, uint64_t{0}}) {
      SCOPED_TRACE(std::to_string(local) + " " + std::to_string(static_cast<int>(shape)));
      Bench bench(3);
      const Corrections fix(std::make_unique<Bcc4Corrections>(file_of(frames, local, shape), 0), bench.memory,
                            cache);
      std::vector<float> values(points.size(), 1.5f);
      std::vector<std::array<float, 4>> slopes(points.size());
      EXPECT_EQ(fix.add_to_points(points, values, slopes, bench.context), 0u);
      constexpr double h = 1e-5;
      for (size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(values[i], 1.5 + expected(frames, shape, points[i]), 1e-5);
        for (size_t a = 0; a < 4 && i % 10 != 0; ++a) {
          Vec4 low = points[i], high = points[i];
          low[a] -= h, high[a] += h;
          EXPECT_NEAR(slopes[i][a], (expected(frames, shape, high) - expected(frames, shape, low)) / (2 * h),
                      1e-4);
        }
      }
      // Where a tent bends, at source samples, that of the side of larger indices.
      for (size_t i = 0; i < points.size(); i += 10) {
        Vec4 high = points[i];
        high[3] += h;
        EXPECT_NEAR(slopes[i][3], (expected(frames, shape, high) - expected(frames, shape, points[i])) / h,
                    1e-3);
      }
      uint64_t count = 1; // the one that is set
      for (const auto& f : frames) count += f.size();
      EXPECT_EQ(fix.count(), count);
      // A sample in a hole gets its value at its own place only, and no other sample anything.
      const std::vector<Vec4> holes{{5, 0, 0, 1}, {5.1, 0, 0, 1}, {6, 0, 0, 1}, {5, 0, 0, 2}};
      std::vector<float> lost(holes.size(), NAN);
      EXPECT_EQ(fix.add_to_points(holes, lost, {}, bench.context), 1u);
      EXPECT_EQ(lost[0], 0.75f);
      for (size_t i = 1; i < lost.size(); ++i) EXPECT_TRUE(std::isnan(lost[i]));
    }
  }
}

TEST(SliceCorrections, GridsAndPointsAgree) {
  std::mt19937 random(4);
  std::vector<GridValue> values;
  for (int i = 0; i < 400; ++i)
    values.push_back(
        {{static_cast<int>(random() % 40), static_cast<int>(random() % 20), static_cast<int>(random() % 35)},
         static_cast<float>(random() % 100) / 10 - 5});
  const SliceCorrections fix{
      {-0.5, 2, 0}, CorrectionShape::smooth, SparseGrid(values), SparseGrid({{{3, 1, 2}, 9.0f}})};
  const Vec3 from{40, 1.3, -2}, step_of{-0.7, 0.45, 0.9};
  const Int3 n{61, 40, 38};
  std::vector<float> grid(static_cast<size_t>(n[0] * n[1] * n[2]));
  fix.add_to_grid(from, step_of, n, grid.data());
  double most = 0;
  for (size_t i = 0; i < grid.size(); ++i) {
    const Vec3 p{from[0] + step_of[0] * static_cast<double>(i % 61),
                 from[1] + step_of[1] * static_cast<double>(i / 61 % 40),
                 from[2] + step_of[2] * static_cast<double>(i / (61 * 40))};
    EXPECT_NEAR(grid[i], fix.at(p, nullptr), 1e-5);
    most = larger(most, std::fabs(static_cast<double>(grid[i])));
    if (i % 501 != 0) continue;
    Vec3 gradient;
    (void)fix.at(p, &gradient);
    for (size_t a = 0; a < 3; ++a) {
      Vec3 low = p, high = p;
      low[a] -= 1e-3, high[a] += 1e-3;
      EXPECT_NEAR(gradient[a], (fix.at(high, nullptr) - fix.at(low, nullptr)) / 2e-3, 2e-2);
    }
  }
  EXPECT_GT(most, 3);
  // Values of one point add up.
  const SparseGrid twice({{{17, 0, 3}, 1.0f}, {{0, 0, 0}, 4.0f}, {{17, 0, 3}, 2.0f}});
  EXPECT_EQ(twice.size(), 2u);
  EXPECT_EQ(*twice.find(17, 0, 3), 3.0f);
  EXPECT_EQ(twice.find(16, 0, 3), nullptr);
  ASSERT_NE(fix.set_at({2.5, 3, 2}), nullptr);
  EXPECT_EQ(fix.set_at({2.6, 3, 2}), nullptr);
}

} // namespace
} // namespace bccsplat
