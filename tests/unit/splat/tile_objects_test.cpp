// SPDX-License-Identifier: Apache-2.0
// Tiles of several objects: each has its own rays, sheets and place in the list, whatever stands beside it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <utility>
#include <vector>

#include "splat/points/kept_points.h"
#include "splat/splat_together.h"
#include "splat/tile/tile_matter.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr int pixels = 96;

// A part of a cube, as sheets see it.
struct Part {
  Part(const SheetView& of, Slice&& cut, const TransferFunction& function)
      : slice(std::move(cut)), view(of),
        table(make_class_table(function, slice.bounds[0], slice.bounds[1], slice.base, 1, 256)) {}
  Slice slice;
  KeptPoints points;
  SheetView view;
  ClassTable table;
  Lights lights;
  [[nodiscard]] SplatObject object(const Context& context) {
    SplatObject out;
    out.scene = {&slice, &points.of(slice, context), &view, &table, &lights, nullptr, nullptr, nullptr};
    return out;
  }
};

class TileObjects : public testing::Test {
 protected:
  TileObjects() {
    const Slice whole =
        make_slice({24, 24, 24}, [](double x, double y, double) { return 0.2 + 0.02 * (x + y); });
    const Camera camera = fit_camera(whole, false, 0, 0, pixels, pixels);
    view_ = make_view(whole, resolve_camera(camera), pixels, pixels, 0.5);
    // Thirds from one side of the picture to the other.
    const Vec3 across = normalized(view_.ex);
    const Vec3 middle = view_.sample(pixels / 2, pixels / 2, 0);
    const double third = length(view_.ex) * pixels / 8;
    for (int n = -1; n <= 1; ++n) {
      Slice part = whole;
      const double at = dot(across, middle) + 2 * n * third;
      part.clip = {{across, third - at}, {-1.0 * across, third + at}};
      parts_.emplace_back(view_, std::move(part), ramp_function(0.1, 1.3, 0.05));
    }
    options_.shading = false, options_.gradient = GradientMethod::fourth_order, options_.tile_size = 40;
  }

  // Draws parts by their numbers, in that order; colours and opacity of each pixel.
  std::vector<std::array<float, 4>> draw(const std::vector<size_t>& which) {
    std::vector<SplatObject> objects;
    for (const size_t n : which) objects.push_back(parts_[n].object(context_.get()));
    std::vector<std::array<float, 4>> out(size_t{pixels} * pixels);
    splat_together(objects, options_, context_.get(), [&](const TilePixels& t) {
      for (int y = 0; y < t.height; ++y)
        for (int x = 0; x < t.width; ++x) {
          const size_t p = plane_index(x, y, t.pitch);
          out[plane_index(t.x + x, t.y + y, pixels)] = {t.red[p], t.green[p], t.blue[p], t.alpha[p]};
        }
    });
    return out;
  }

  TestContext context_{2};
  SheetView view_;
  std::deque<Part> parts_;
  SplatOptions options_;
};

// Where the rays of one part alone are, a picture of all is that part's, wherever it stands among them.
TEST_F(TileObjects, HaveTheirOwnRays) {
  const std::vector<std::vector<size_t>> orders{{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
  std::vector<std::vector<std::array<float, 4>>> alone;
  for (size_t n = 0; n < 3; ++n) alone.push_back(draw({n}));
  for (const auto& order : orders) {
    const auto all = draw(order);
    std::array<int, 3> seen{};
    for (size_t p = 0; p < all.size(); ++p) {
      size_t of = 3, parts = 0;
      for (size_t n = 0; n < 3; ++n)
        if (alone[n][p][3] > 0) of = n, ++parts;
      if (parts > 1) continue; // a pixel that two of them reach
      for (size_t c = 0; c < 4; ++c)
        ASSERT_NEAR(all[p][c], parts ? alone[of][p][c] : 0, 1e-6) << p << ' ' << of;
      if (parts) ++seen[of];
    }
    for (const int count : seen) EXPECT_GT(count, pixels * pixels / 30);
  }
}

// A field that is drawn as two objects absorbs what one of twice the extinction does.
TEST_F(TileObjects, AddTheirExtinctions) {
  const auto twice = draw({1, 1});
  for (auto& entry : parts_[1].table.entry) entry[3] *= 2;
  const auto dense = draw({1});
  double most = 0;
  for (size_t p = 0; p < twice.size(); ++p) {
    for (size_t c = 0; c < 4; ++c) ASSERT_NEAR(twice[p][c], dense[p][c], 1e-5) << p;
    most = std::max<double>(most, dense[p][3]);
  }
  EXPECT_GT(most, 0.1);
}

// Stills have planes of matter for each group, pairs included; an object that is drawn alone has none.
TEST(TileMatter, HasPlanesForEachGroup) {
  TileJob job;
  EXPECT_EQ(matter_planes(job), 0u);
  const std::vector<SplatStill> stills(1);
  job.stills = stills;
  EXPECT_EQ(job.groups(), 2u);
  const uint64_t two = matter_planes(job);
  EXPECT_EQ(two, 2 * group_planes * most_sheets_at_once);
  const std::vector<TrailCombine> pairs(3);
  job.pairs = pairs;
  EXPECT_EQ(job.groups(), 8u);
  EXPECT_EQ(matter_planes(job), 4 * two);
}

} // namespace
} // namespace bccsplat
