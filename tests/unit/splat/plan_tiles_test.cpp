// SPDX-License-Identifier: Apache-2.0
// Tiles that hold too much for one of several threads are cut, and the picture stays the same.
#include "splat/plan/plan_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

// A volume in the middle of the picture, which a few tiles see.
struct Planned {
  Slice slice = make_slice({40, 40, 40}, marschner_lobb(40));
  TransferFunction function = ramp_function(0.3, 1, 0.1);
  TestContext context{8};
  SplatPoints points = make_points(slice, context.get());
  ClassTable table = make_class_table(function, slice.bounds[0], slice.bounds[1], slice.base, 1, 256);
  Lights lights;
  Camera camera = fit_camera(slice, false, 20, 30, 512, 512);
  SheetView view = make_view(slice, resolve_camera(camera), 512, 512, 0.5);
  SplatPlan plan;

  Planned() {
    SplatOptions options;
    options.shading = false;
    camera.ortho_height *= 2.5;
    view = make_view(slice, resolve_camera(camera), 512, 512, 0.5);
    DrawStats stats;
    plan = make_plan({&slice, &points, &view, &table, &lights}, options, context.get(), stats);
  }
};

TEST(PlanTiles, EveryPixelIsInOneTile) {
  Planned p;
  const size_t before = p.plan.tiles.size();
  divide_tiles(p.plan, 8);
  EXPECT_GT(p.plan.tiles.size(), before);
  std::vector<int> covered(size_t{512} * 512);
  for (const PlannedTile& t : p.plan.tiles)
    for (int y = t.y; y < t.y + t.height; ++y)
      for (int x = t.x; x < t.x + t.width; ++x) ++covered[static_cast<size_t>(y) * 512 + x];
  EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), 512 * 512);
}

// Every thread takes the tile with the most work that is left.
TEST(PlanTiles, EightThreadsEndTogether) {
  Planned p;
  const auto longest = [&] {
    std::vector<double> busy(8);
    for (const size_t n : tiles_by_work(p.plan))
      *std::min_element(busy.begin(), busy.end()) += tile_work(p.plan, p.plan.tiles[n]);
    double sum = 0;
    for (const double b : busy) sum += b;
    return 8 * *std::max_element(busy.begin(), busy.end()) / sum;
  };
  const double uncut = longest();
  divide_tiles(p.plan, 8);
  EXPECT_GT(uncut, 1.5);
  EXPECT_LT(longest(), 0.8 * uncut);
  const std::vector<size_t> order = tiles_by_work(p.plan);
  EXPECT_GE(tile_work(p.plan, p.plan.tiles[order.front()]), tile_work(p.plan, p.plan.tiles[order.back()]));
}

TEST(PlanTiles, OneThreadHasNoneCut) {
  Planned p;
  const size_t before = p.plan.tiles.size();
  divide_tiles(p.plan, 1);
  EXPECT_EQ(p.plan.tiles.size(), before);
}

TEST(PlanTiles, ThreadsChangeNoBit) {
  const Slice slice = make_slice({24, 24, 24}, marschner_lobb(24));
  for (const bool perspective : {false, true}) {
    const Scene scene =
        make_scene(slice, ramp_function(0.3, 1, 0.1), fit_camera(slice, perspective, 20, 30, 300, 300));
    ImageStorage one(300, 300), many(300, 300);
    const RenderStats alone = draw(scene, {}, one, 1), divided = draw(scene, {}, many, 7);
    EXPECT_GT(divided.drawn.tiles, alone.drawn.tiles);
    EXPECT_EQ(one.rgba, many.rgba);
  }
}

} // namespace
} // namespace bccsplat
