// SPDX-License-Identifier: Apache-2.0
// Smooth edges of isosurfaces: coverage against the analytic one, pictures against the means of pictures of
// eight times the size, and what stays as it is.
#include "draw/smooth_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "draw/deep.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

constexpr int field_edge = 32, image_edge = 96;
constexpr double field_middle = (field_edge - 1) / 2.0, radius = 9;

// Falls off around a sphere slowly enough for the lattice to hold it; 0.5 on it.
double soft_ball(const Vec3& p, const Vec3& centre, double r) {
  return 1 / (1 + std::exp(0.7 * (length(p - centre) - r)));
}

Slice one_ball() {
  return test::make_slice({field_edge, field_edge, field_edge}, [](double x, double y, double z) {
    return soft_ball({x, y, z}, {field_middle, field_middle, field_middle}, radius);
  });
}

// A small ball in front of a large one, from any side that is looked from here.
Slice two_balls() {
  return test::make_slice({field_edge, field_edge, field_edge}, [](double x, double y, double z) {
    return soft_ball({x, y, z}, {field_middle, field_middle, 21}, 8.5) +
           soft_ball({x, y, z}, {field_middle + 2, field_middle + 3, 6}, 4);
  });
}

// A plane that ends a ray cuts through the ball, and data are missing in a part of it.
Slice cut_ball() {
  Slice s = one_ball();
  const Vec3 at = s.lattice_to_slice.inverse().point({field_middle - 4, field_middle, field_middle});
  const Vec3 normal = normalized({1, 0.2, 0.3});
  s.clip.push_back({normal, -dot(normal, at)});
  return s;
}
Slice holed_ball() {
  Slice s = one_ball();
  for (auto& layer : s.coset)
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      if (!layer.brick(slot)) continue;
      auto brick = std::make_shared<Brick>();
      brick->value = layer.brick(slot)->value;
      brick->kept = layer.brick(slot)->kept;
      brick->hole = std::make_unique<BrickMask>();
      brick->hole->fill(0x003e); // sites 1 to 5 of each row
      layer.set(slot, std::move(brick));
    }
  s.has_holes = true;
  return s;
}

struct Pair {
  ImageStorage plain{image_edge, image_edge, true, true, true},
      smooth{image_edge, image_edge, true, true, true};
  RenderStats stats;

  Pair(const Slice& s, const Camera& camera, RenderOptions o = {}, int threads = 2) {
    const Scene scene = test::make_scene(s, test::ramp_function(0, 1, 0.5), camera);
    o.mode = RenderMode::isosurface, o.iso_value = 0.5;
    (void)test::draw(scene, o, plain, threads);
    o.smooth_edges = true;
    stats = test::draw(scene, o, smooth, threads);
  }
  [[nodiscard]] bool changed(int i, int j) const {
    const float *const a = plain.image.rgba.at(i, j), *const b = smooth.image.rgba.at(i, j);
    return !std::equal(a, a + 4, b);
  }
};

Camera camera_of(const Slice& s, bool perspective = false) {
  return fit_camera(s, perspective, 20, 30, image_edge, image_edge);
}

double square(float a, double b) { return (a - b) * (a - b); }

} // namespace

TEST(SmoothEdges, ABallCoversWhatItsCircleDoes) {
  const Slice s = one_ball();
  const Pair p(s, camera_of(s));
  const SheetView view = make_view(s, resolve_camera(camera_of(s)), image_edge, image_edge, 0.5);
  const Vec3 centre = s.lattice_to_slice.inverse().point({field_middle, field_middle, field_middle});
  const Vec3 along = normalized(view.lattice_to_world.vector(view.ray(0, 0)));
  const double pixel = length(view.lattice_to_world.vector(view.ex));
  const auto outside = [&](double i, double j) { // world length of a ray's distance from the sphere
    const Vec3 d = view.lattice_to_world.vector(view.sample(i, j, 0) - centre);
    return length(d - dot(d, along) * along) - radius;
  };
  double plain = 0, smooth = 0;
  int edges = 0;
  for (int j = 0; j < image_edge; ++j)
    for (int i = 0; i < image_edge; ++i) {
      if (std::fabs(outside(i, j)) > 1.8 * pixel) {
        EXPECT_FALSE(p.changed(i, j)) << i << ' ' << j;
      }
      constexpr int grid = 32;
      int count = 0;
      for (int b = 0; b < grid; ++b)
        for (int a = 0; a < grid; ++a)
          count += outside(i + (a + 0.5) / grid - 0.5, j + (b + 0.5) / grid - 0.5) < 0;
      if (count == 0 || count == grid * grid) continue;
      const double share = static_cast<double>(count) / (grid * grid);
      ++edges;
      plain += square(p.plain.image.rgba.at(i, j)[3], share);
      smooth += square(p.smooth.image.rgba.at(i, j)[3], share);
    }
  ASSERT_GT(edges, 100);
  EXPECT_GT(std::sqrt(plain / edges), 0.19);
  EXPECT_LT(std::sqrt(smooth / edges), 0.12); // quarters
}

// What is drawn comes nearer to the mean of 8 x 8 pixels, silhouettes and edges within the picture alike.
TEST(SmoothEdges, AreMeansOfFinerPictures) {
  constexpr int factor = 8;
  const auto closer = [&](const char* name, const Slice& s, const Camera& camera) {
    const Pair p(s, camera);
    ImageStorage large(factor * image_edge, factor * image_edge);
    RenderOptions o;
    o.mode = RenderMode::isosurface, o.iso_value = 0.5;
    (void)test::draw(test::make_scene(s, test::ramp_function(0, 1, 0.5), camera), o, large);
    double plain = 0, smooth = 0;
    int edges = 0, within = 0;
    for (int j = 0; j < image_edge; ++j)
      for (int i = 0; i < image_edge; ++i) {
        if (!p.changed(i, j)) continue;
        ++edges;
        within += p.smooth.image.rgba.at(i, j)[3] == 1;
        for (int c = 0; c < 4; ++c) {
          double mean = 0;
          for (int b = 0; b < factor; ++b)
            for (int a = 0; a < factor; ++a) mean += large.image.rgba.at(factor * i + a, factor * j + b)[c];
          mean /= factor * factor;
          plain += square(p.plain.image.rgba.at(i, j)[c], mean);
          smooth += square(p.smooth.image.rgba.at(i, j)[c], mean);
        }
      }
    EXPECT_GT(edges, 60) << name;
    EXPECT_LE(static_cast<uint64_t>(edges), p.stats.edge_pixels) << name;
    EXPECT_LT(std::sqrt(smooth), std::sqrt(plain) / 1.9) << name;
    return within;
  };
  for (const bool perspective : {false, true}) {
    const Slice one = one_ball(), two = two_balls(), cut = cut_ball(), holed = holed_ball();
    closer("ball", one, camera_of(one, perspective));
    EXPECT_GT(closer("two balls", two, fit_camera(two, perspective, 10, 180, image_edge, image_edge)), 50);
    closer("cut", cut, camera_of(cut, perspective));
    closer("holes", holed, camera_of(holed, perspective));
    const Slice waves =
        test::make_slice({field_edge, field_edge, field_edge}, test::marschner_lobb(field_edge, 4));
    EXPECT_GT(closer("waves", waves, camera_of(waves, perspective)), 200);
  }
}

TEST(SmoothEdges, NeitherThreadsNorTilesChangeABit) {
  const Slice s = test::make_slice({field_edge, field_edge, field_edge}, test::marschner_lobb(field_edge, 4));
  const Pair one(s, camera_of(s), {}, 1), four(s, camera_of(s), {}, 4);
  EXPECT_GT(one.stats.edge_pixels, 500u);
  EXPECT_EQ(one.smooth.rgba, four.smooth.rgba);
  RenderOptions tiles;
  tiles.tile_size = 16;
  EXPECT_EQ(one.smooth.rgba, Pair(s, camera_of(s), tiles).smooth.rgba);
}

TEST(SmoothEdges, OtherPlanesAreThoseOfPixelCentres) {
  const Slice s = two_balls();
  const Pair p(s, camera_of(s));
  EXPECT_NE(p.plain.rgba, p.smooth.rgba);
  const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0; // NaN where nothing is
  };
  EXPECT_TRUE(same(p.plain.depth, p.smooth.depth));
  EXPECT_TRUE(same(p.plain.value, p.smooth.value));
  EXPECT_TRUE(same(p.plain.time, p.smooth.time));
}

TEST(SmoothEdges, DeepPicturesHaveOneDepthPerPixel) {
  const Slice s = one_ball();
  RenderOptions o;
  o.rays = false; // which draw nothing deep
  Pair p(s, camera_of(s), o);
  test::TestContext context;
  DeepImage deep;
  p.smooth.image.deep = &deep;
  o.mode = RenderMode::isosurface, o.iso_value = 0.5, o.smooth_edges = true;
  const RenderStats stats = render(test::make_scene(s, test::ramp_function(0, 1, 0.5), camera_of(s)), o,
                                   context.get(), p.smooth.image);
  EXPECT_EQ(stats.edge_pixels, 0u);
  EXPECT_EQ(p.plain.rgba, p.smooth.rgba);
}

TEST(SmoothEdges, DepthsAreReservedFromTheBudget) {
  const Slice s = one_ball();
  test::TestContext of_points; // outlives them
  const KeptPoints points(make_points(s, of_points.get()));
  Scene scene = test::make_scene(s, test::ramp_function(0, 1, 0.5), camera_of(s));
  scene.points = &points;
  RenderOptions o;
  o.mode = RenderMode::isosurface, o.iso_value = 0.5, o.smooth_edges = true;
  ImageStorage image(image_edge, image_edge);
  Tasks tasks(1);
  MemoryBudget budget;
  Progress progress;
  (void)render(scene, o, {tasks, budget, progress}, image.image);
  EXPECT_GE(budget.peak(), image_edge * image_edge * sizeof(float));
  EXPECT_EQ(budget.used(), 0u);
}

} // namespace bccsplat
