// SPDX-License-Identifier: Apache-2.0
// Several isosurfaces in one picture, opaque and transparent: against the reference, against pictures of
// single values, from both sides, with their planes, deep samples and edges.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "draw/deep.h"
#include "splat/loop/loops.h"
#include "splat/splat.h"
#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

constexpr int n = 32, size = 96;
constexpr double middle = (n - 1) / 2.0;

// A ball whose value falls with the distance from its middle, and a smaller one beside it, below air.
Slice balls() {
  return test::make_slice({n, n, n}, [](double x, double y, double z) {
    const auto ball = [&](const Vec3& centre, double r) {
      return 1 / (1 + std::exp(0.6 * (length(Vec3{x, y, z} - centre) - r)));
    };
    return ball({middle, middle, middle - 3}, 9) - 0.8 * ball({middle + 7, middle + 3, middle + 9}, 4);
  });
}
Slice waves() { return test::make_slice({n, n, n}, test::marschner_lobb(n, 3)); }

struct Drawn {
  ImageStorage image{size, size, true, true, true};
  RenderStats stats;

  Drawn(const Slice& s, std::vector<IsoSurface> surfaces, RenderOptions o = {}, double rotate_y = 30,
        bool perspective = false, int threads = 2) {
    const Scene scene = test::make_scene(s, test::ramp_function(0, 1, 0.5),
                                         fit_camera(s, perspective, 20, rotate_y, size, size));
    o.mode = RenderMode::isosurface, o.surfaces = std::move(surfaces);
    stats = test::draw(scene, o, image, threads);
  }
  [[nodiscard]] const float* at(int p) const { return image.image.rgba.at(p % size, p / size); }
};

bool same(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}
bool same(const Drawn& a, const Drawn& b) {
  return same(a.image.rgba, b.image.rgba) && same(a.image.depth, b.image.depth) &&
         same(a.image.value, b.image.value) && same(a.image.time, b.image.time);
}

// Shares of pixels that differ by more than a hundredth in one of the planes.
double share_off(const Drawn& a, const Drawn& b) {
  int off = 0;
  for (int p = 0; p < size * size; ++p) {
    bool differs = false;
    for (int c = 0; c < 4; ++c) differs |= std::fabs(a.at(p)[c] - b.at(p)[c]) > 0.01f;
    const size_t at = p;
    const float da = a.image.depth[at], db = b.image.depth[at];
    differs |= std::isinf(da) != std::isinf(db) || (!std::isinf(da) && std::fabs(da - db) > 0.02f);
    const float va = a.image.value[at], vb = b.image.value[at];
    differs |= std::isnan(va) != std::isnan(vb) || (!std::isnan(va) && std::fabs(va - vb) > 0.01f);
    off += differs;
  }
  return static_cast<double>(off) / (size * size);
}

const std::vector<IsoSurface> mixed{
    {0.7, 1, {}}, {0.25, 0.4, Vec3{0.2, 0.4, 1}}, {0.5, 0.3, {}}, {-0.3, 0.6, {}}};

} // namespace

TEST(SeveralSurfaces, AreThoseOfTheReference) {
  for (const bool perspective : {false, true}) {
    const Slice s = perspective ? waves() : balls();
    RenderOptions o, slow;
    o.quality = Quality::fine, slow.reference = true;
    const Drawn fast(s, mixed, o, 30, perspective), reference(s, mixed, slow, 30, perspective);
    EXPECT_LT(share_off(fast, reference), 0.01) << perspective;
    int partly = 0;
    for (int p = 0; p < size * size; ++p) partly += fast.at(p)[3] > 0.2f && fast.at(p)[3] < 0.98f;
    EXPECT_GT(partly, 300); // light passes some
  }
}

TEST(SeveralSurfaces, OneOpaqueIsTheSingleValueBitForBit) {
  const Slice s = waves();
  for (const bool edges : {false, true}) {
    RenderOptions o;
    o.smooth_edges = edges, o.iso_value = 0.5;
    EXPECT_TRUE(same(Drawn(s, {}, o), Drawn(s, {{0.5, 1, {}}}, o)));
  }
}

TEST(SeveralSurfaces, OfTwoOpaqueOnesTheNearerIsSeen) {
  const Slice s = balls();
  RenderOptions by_sheets;
  by_sheets.rays = false; // which draw no two surfaces
  for (const double side : {30.0, 210.0}) {
    const Drawn low(s, {{0.3, 1, {}}}, by_sheets, side), high(s, {{-0.2, 1, {}}}, by_sheets, side),
        both(s, {{0.3, 1, {}}, {-0.2, 1, {}}}, {}, side);
    int of_low = 0, of_high = 0;
    for (int p = 0; p < size * size; ++p) {
      const size_t at = p;
      const bool nearer = low.image.depth[at] <= high.image.depth[at];
      const Drawn& seen = nearer ? low : high;
      ASSERT_EQ(std::memcmp(both.at(p), seen.at(p), 4 * sizeof(float)), 0) << p;
      ASSERT_EQ(both.image.depth[at], seen.image.depth[at]);
      (nearer ? of_low : of_high) += seen.at(p)[3] > 0;
    }
    EXPECT_GT(of_low, 500);
    EXPECT_GT(of_high, 50);
  }
}

TEST(SeveralSurfaces, WithoutOpacityThereIsNone) {
  const Slice s = balls();
  for (const bool edges : {false, true}) {
    RenderOptions o;
    o.smooth_edges = edges;
    EXPECT_TRUE(
        same(Drawn(s, {{0.5, 0.5, {}}}, o), Drawn(s, {{0.2, 0, {}}, {0.5, 0.5, {}}, {0.8, 0, {}}}, o)));
    const Drawn none(s, {{0.5, 0, {}}}, o);
    EXPECT_EQ(none.image.rgba, std::vector<float>(none.image.rgba.size()));
    EXPECT_EQ(none.stats.drawn.points_splatted, 0u);
  }
}

// Light that passes a closed surface meets it twice, and what is nearer is laid over what is farther.
TEST(SeveralSurfaces, FollowEachOtherInDepthFromEitherSide) {
  const Slice s = balls();
  RenderOptions o;
  o.rays = false; // which draw no two surfaces
  o.shading = false;
  const Vec3 red{1, 0, 0}, blue{0, 0, 1};
  for (const double side : {0.0, 180.0}) {
    const Drawn d(s, {{0.5, 0.5, red}, {-0.2, 0.5, blue}}, o, side);
    const Drawn first(s, {{0.5, 1, red}}, o, side), second(s, {{-0.2, 1, blue}}, o, side);
    int both = 0;
    for (int p = 0; p < size * size; ++p) {
      const size_t at = p;
      const float ball = first.image.depth[at], small = second.image.depth[at];
      if (!(d.at(p)[3] > 0.93f) || std::isinf(ball) || std::isinf(small)) continue;
      ++both;
      // Two hits of each, the nearer ball's first: 1/2, 1/4, 1/8, 1/16.
      EXPECT_NEAR(d.at(p)[0], ball < small ? 0.75f : 0.1875f, 1e-5f) << p;
      EXPECT_NEAR(d.at(p)[2], ball < small ? 0.1875f : 0.75f, 1e-5f) << p;
      EXPECT_EQ(d.image.depth[at], std::min(ball, small));
    }
    EXPECT_GT(both, 60) << side;
  }
}

TEST(SeveralSurfaces, SkipsThreadsAndTilesChangeNoBit) {
  for (const Slice& s : {balls(), waves()})
    for (const auto& surfaces :
         {mixed, std::vector<IsoSurface>{{0.35, 0.5, {}}, {0.6, 0.5, {}}, {0.8, 1, {}}}}) {
      RenderOptions o, other;
      o.smooth_edges = other.smooth_edges = true;
      const Drawn drawn(s, surfaces, o);
      EXPECT_GT(drawn.stats.edge_pixels, 200u);
      other.disable_skips = skip_transfer_function | skip_cells | skip_occlusion | skip_empty_sheets;
      EXPECT_TRUE(same(drawn, Drawn(s, surfaces, other)));
      other.disable_skips = 0, other.tile_size = 16;
      EXPECT_TRUE(same(drawn, Drawn(s, surfaces, other, 30, false, 4)));
      EXPECT_TRUE(same(drawn, Drawn(s, {surfaces.rbegin(), surfaces.rend()}, o)));
    }
}

TEST(SeveralSurfaces, DeepSamplesAreTheHits) {
  const Slice s = balls();
  for (const double stop : {0.995, 1.0}) {
    Scene scene =
        test::make_scene(s, test::ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size));
    RenderOptions o;
    o.mode = RenderMode::isosurface, o.surfaces = {{0.3, 0.4, {}}, {0.6, 0.5, {}}, {-0.2, 1, {}}};
    o.opacity_stop = stop;
    test::TestContext context;
    ImageStorage flat(size, size, true);
    DeepImage deep;
    flat.image.deep = &deep;
    (void)render(scene, o, context.get(), flat.image);
    size_t most = 0, behind = 0;
    for (size_t p = 0; p < size * size; ++p) {
      double sum[4] = {}, before = -std::numeric_limits<double>::infinity();
      bool opaque = false;
      most = std::max(most, static_cast<size_t>(deep.first[p + 1] - deep.first[p]));
      for (uint64_t m = deep.first[p]; m < deep.first[p + 1]; ++m) {
        const float* const sample = deep.samples.data() + m * DeepImage::components;
        EXPECT_EQ(sample[0], sample[1]);
        EXPECT_GE(static_cast<double>(sample[0]), before);
        before = sample[0];
        behind += opaque;
        opaque |= sample[2] == 1;
        const double passed = 1 - sum[3];
        for (size_t c = 0; c < 3; ++c) sum[c] += passed * sample[3 + c];
        sum[3] += passed * sample[2];
      }
      const float* const rgba = flat.rgba.data() + 4 * p;
      for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(sum[c], rgba[c], 1e-5);
      if (deep.first[p + 1] > deep.first[p]) {
        EXPECT_EQ(deep.samples[deep.first[p] * DeepImage::components], flat.depth[p]);
      }
    }
    EXPECT_GE(most, 4u);
    EXPECT_EQ(behind > 0, stop == 1);
  }
}

// Edges of what lies behind a transparent surface are smoothed as those in front.
TEST(SeveralSurfaces, SmoothEdgesAreMeansOfFinerPictures) {
  constexpr int factor = 8;
  const Slice s = balls();
  for (const auto& surfaces :
       {std::vector<IsoSurface>{{0.3, 1, {}}, {-0.2, 1, {}}}, {{0.2, 0.4, {}}, {0.6, 1, {}}}, mixed}) {
    RenderOptions o;
    const Drawn plain(s, surfaces, o);
    o.smooth_edges = true;
    const Drawn smooth(s, surfaces, o);
    ImageStorage large(factor * size, factor * size);
    o.smooth_edges = false, o.mode = RenderMode::isosurface, o.surfaces = surfaces;
    (void)test::draw(
        test::make_scene(s, test::ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size)), o,
        large);
    double before = 0, after = 0;
    int changed = 0;
    for (int p = 0; p < size * size; ++p) {
      if (std::equal(plain.at(p), plain.at(p) + 4, smooth.at(p))) continue;
      ++changed;
      for (int c = 0; c < 4; ++c) {
        double mean = 0;
        for (int b = 0; b < factor; ++b)
          for (int a = 0; a < factor; ++a)
            mean += large.image.rgba.at(factor * (p % size) + a, factor * (p / size) + b)[c];
        mean /= factor * factor;
        before += std::pow(plain.at(p)[c] - mean, 2);
        after += std::pow(smooth.at(p)[c] - mean, 2);
      }
    }
    EXPECT_GT(changed, 150);
    EXPECT_LT(std::sqrt(after), std::sqrt(before) / 1.7);
  }
}

TEST(SeveralSurfaces, ReferenceLoopsFindWhatVectorsFind) {
  const Slice s = waves();
  test::TestContext context;
  const SplatPoints points = make_points(s, context.get());
  Scene scene = test::make_scene(s, test::ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size));
  const SheetView view = make_view(s, resolve_camera(scene.camera), size, size, 0.5);
  const ClassTable table = make_class_table(scene.function, s.bounds[0], s.bounds[1], s.base, 1, 1024);
  SplatOptions o;
  o.mode = RenderMode::isosurface, o.surfaces = {{0.3, 0.4, {}}, {0.5, 0.6, {}}, {0.8, 1, {}}};
  const auto draw = [&](bool reference) {
    o.reference_loops = reference;
    std::vector<float> alpha(size * size);
    (void)splat({&s, &points, &view, &table, &scene.lights}, o, context.get(), [&](const TilePixels& t) {
      for (int y = 0; y < t.height; ++y)
        std::copy_n(t.alpha + static_cast<std::ptrdiff_t>(y) * t.pitch, t.width,
                    alpha.begin() + static_cast<std::ptrdiff_t>(t.y + y) * size + t.x);
    });
    return alpha;
  };
  const auto slow = draw(true);
  EXPECT_GT(*std::max_element(slow.begin(), slow.end()), 0.99f);
  test::for_targets([&] {
    const auto vectors = draw(false);
    int off = 0;
    for (size_t p = 0; p < vectors.size(); ++p) off += std::fabs(vectors[p] - slow[p]) > 1e-5f;
    EXPECT_LT(off, size * size / 1000);
  });
}

} // namespace bccsplat
