// SPDX-License-Identifier: Apache-2.0
// Which points are near enough to large ones: the words of bits are compared with loops, and pictures with
// and without the other points.
#include "splat/points/point_sizes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using namespace test;

TEST(PointSizes, CodesRiseWithTheCoefficient) {
  SplatPoints points;
  for (const float unit : {1.0f, 0.125f, 4096.0f}) {
    points.code_unit = unit;
    int before = 0;
    for (float c = 1e-7f / unit; c < 100 / unit; c *= 1.01f) {
      const int code = points.code(-c);
      ASSERT_EQ(code, points.code(c));
      ASSERT_GE(code, before);
      before = code;
      if (code < SplatPoints::most_code) {
        ASSERT_LT(c, points.code_begin(code + 1));
      }
      if (code > 0) {
        ASSERT_GE(c, points.code_begin(code));
      }
    }
    EXPECT_EQ(before, SplatPoints::most_code);
  }
}

TEST(PointSizes, CellsFromCodes) {
  std::mt19937 random(5);
  std::array<uint8_t, SplatPoints::fine_cells> codes;
  for (uint8_t& c : codes) c = static_cast<uint8_t>(random() % 128);
  for (const int least : {1, 2, 60, 126, 127}) {
    const FineCells cells = cells_from(codes.data(), static_cast<uint8_t>(least));
    for (size_t n = 0; n < codes.size(); ++n)
      ASSERT_EQ(cells[n >> 6] >> (n & 63) & 1, codes[n] >= least) << n;
  }
}

// Looks at every pair of points, one in a large cell of any of the 27 bricks, one in the middle brick.
TEST(PointSizes, BallsMeetTheCellsThatArePossiblyNear) {
  std::mt19937 random(6);
  for (const int edge : {8, 4})
    for (const double distance : {3.0, 5.74, 6.0}) {
      const double plane = edge == 8 ? std::sqrt(0.5) : 1.0;
      ASSERT_LE(distance, farthest(plane));
      FineCube cube;
      std::vector<Int3> large; // cells, 0 is the middle brick's first
      for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
          for (int x = -1; x <= 1; ++x) {
            FineCells cells{};
            for (int k = 0; k < 2; ++k) {
              std::array<unsigned, 3> at;
              for (unsigned& n : at) n = static_cast<unsigned>(random() % static_cast<unsigned>(edge));
              cells[at[2]] |= uint64_t{1} << (at[0] | at[1] << 3);
              large.push_back({x * edge + static_cast<int>(at[0]), y * edge + static_cast<int>(at[1]),
                               z * edge + static_cast<int>(at[2])});
            }
            cube.add(cells, {x, y, z}, edge);
          }
      const FineBall ball = make_ball(distance, plane);
      const FineCells got = cells_within_reference(cube, ball);
      for_targets([&] { EXPECT_EQ(cells_within(cube, ball), got); });
      for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
          for (int x = 0; x < edge; ++x) {
            bool near = false;
            for (const Int3& c : large) {
              const int apart[3] = {c[0] - x, c[1] - y, c[2] - z};
              double square = 0; // planes, between the nearest points that the cells may hold
              for (const int n : apart) square += n == 0 ? 0 : std::pow(2 * std::abs(n) - 1, 2);
              near = near || plane * std::sqrt(square) <= distance;
            }
            ASSERT_EQ(got[z] >> (x | y << 3) & 1, near) << x << ' ' << y << ' ' << z;
          }
    }
}

TEST(PointSizes, PointsAreTakenInTheirOrder) {
  std::mt19937 random(7);
  for (const uint32_t count : {1u, 15u, 16u, 100u, 1000u}) {
    SplatPoints points;
    SplatBrick brick;
    brick.first = 5, brick.count = count;
    for (uint32_t n = 0; n < count + 40; ++n) {
      points.position.push_back(static_cast<uint16_t>(random() & 0xfff));
      points.coefficient.push_back(static_cast<float>(n));
    }
    FineCells cells;
    for (uint64_t& word : cells) word = uint64_t{random()} << 32 | random(); // every second cell
    std::vector<uint16_t> expected_position, position(count + 1);
    std::vector<float> expected, coefficient(count + 1);
    for (uint32_t n = 5; n < 5 + count; ++n)
      if (const unsigned cell = fine_cell(points.position[n]); cells[cell >> 6] >> (cell & 63) & 1)
        expected_position.push_back(points.position[n]), expected.push_back(points.coefficient[n]);
    EXPECT_TRUE(count < 100 || (expected.size() > count / 4 && expected.size() < count)) << expected.size();
    const auto check = [&](uint32_t kept) {
      ASSERT_EQ(kept, expected.size());
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), coefficient.begin()));
      EXPECT_TRUE(std::equal(expected_position.begin(), expected_position.end(), position.begin()));
      EXPECT_EQ(coefficient[count], -1.0f); // beyond the brick
      EXPECT_EQ(position[count], 7);
    };
    coefficient[count] = -1, position[count] = 7;
    for_targets([&] { check(take_points(points, brick, cells, position.data(), coefficient.data())); });
    check(take_points_reference(points, brick, cells, position.data(), coefficient.data()));
  }
}

// Points are copied where the budget has four times the room, and else drawn from where they are.
TEST(PointSizes, CopiesStayWithinTheBudget) {
  test::TestContext context;
  const Slice slice = make_slice({50, 48, 46}, [](double x, double y, double z) {
    return std::exp(-std::pow(std::hypot(x - 20, y - 23, z - 23) / 8, 2));
  });
  const KeptPoints kept;
  const SplatPoints& points = kept.of(slice, context.get());
  TransferFunction f = test::ramp_function(0.35, 1, 0.4);
  f.opacities.insert(f.opacities.begin(), {0.3, 0});
  Scene scene = make_scene(slice, f, fit_camera(slice, false, 20, 30, 60, 60));
  scene.points = &kept;
  RenderOptions o;
  o.raise = RaiseFilter{};
  Tasks tasks(2);
  Progress progress;
  ImageStorage few(60, 60), all(60, 60);
  const auto picture = [&](uint64_t limit, ImageStorage& image) {
    MemoryBudget memory(limit);
    const RenderStats stats = render(scene, o, {tasks, memory, progress}, image.image);
    EXPECT_EQ(memory.used(), 0u);
    EXPECT_EQ(memory.peak() > 0, stats.drawn.points_invisible > points.count / 8);
    EXPECT_LE(4 * memory.peak(), limit);
    return memory.peak();
  };
  const uint64_t copies = picture(uint64_t{1} << 40, few);
  EXPECT_GT(copies, uint64_t{points.count} * 6);
  EXPECT_EQ(picture(4 * copies, few), copies);
  EXPECT_EQ(picture(4 * copies - 1, all), 0u);
  EXPECT_EQ(std::memcmp(few.rgba.data(), all.rgba.data(), all.rgba.size() * sizeof(float)), 0);
}

TEST(PointSizes, FarPointsChangeNothing) {
  for (const LatticeKind kind : {LatticeKind::bcc, LatticeKind::cc}) {
    // A ball with a long faint tail, and a second one below air.
    const Slice slice = make_slice(
        {50, 48, 46},
        [](double x, double y, double z) {
          return std::exp(-std::pow(std::hypot(x - 20, y - 23, z - 23) / 8, 2)) -
                 0.7 * std::exp(-std::pow(std::hypot(x - 38, y - 20, z - 20) / 5, 2));
        },
        "default", {}, 0, kind);
    TransferFunction f;
    f.colors = {{-1, {1, 0.5, 0.2}}, {1, {0.2, 0.7, 1}}};
    f.opacities = {{-1, 0.4}, {-0.5, 0.2}, {-0.45, 0}, {0.3, 0}, {0.35, 0.2}, {1, 0.4}};
    for (const bool perspective : {false, true})
      for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface}) {
        const Scene scene = make_scene(slice, f, fit_camera(slice, perspective, 20, 30, 60, 60));
        RenderOptions o;
        o.rays = false;
        o.mode = mode, o.iso_value = 0.4, o.raise = RaiseFilter{};
        o.gradient = GradientMethod::fourth_order, o.sheet_step = 0.5;
        ImageStorage few(60, 60, true, true, true), all(60, 60, true, true, true);
        const RenderStats some = draw(scene, o, few);
        EXPECT_GT(some.drawn.points_invisible, some.drawn.points_total / 8);
        EXPECT_GT(*std::max_element(few.rgba.begin(), few.rgba.end()), 0.2f);
        o.disable_skips = skip_transfer_function | skip_cells;
        draw(scene, o, all);
        EXPECT_EQ(std::memcmp(few.rgba.data(), all.rgba.data(), all.rgba.size() * sizeof(float)), 0)
            << perspective << static_cast<int>(mode);
      }
  }
}

} // namespace
} // namespace bccsplat
