// SPDX-License-Identifier: Apache-2.0
// Deep pictures: composited they are the flat picture, cut anywhere they are what lies in front, and OpenEXR
// reads them as we write them.
#include "draw/deep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <random>

#include "draw/deep_tile.h"
#include "formats/image/exr.h"
#include "scene/trail.h"
#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"

#if __has_include(<ImfDeepScanLineInputFile.h>)
#include <ImfChannelList.h>
#include <ImfCompositeDeepScanLine.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfStandardAttributes.h>
#endif

namespace bccsplat {
namespace {

using test::draw;

constexpr int width = 56, height = 40;
constexpr double no_merging = 1e-9;

struct Deep {
  std::unique_ptr<test::TestContext> context; // the samples count against its budget
  ImageStorage flat{width, height, true};
  DeepImage image;

  void draw(const Scene& scene, const RenderOptions& options, int threads = 2) {
    image = {};
    context = std::make_unique<test::TestContext>(threads);
    flat.image.deep = &image;
    (void)render(scene, options, context->get(), flat.image);
  }
  [[nodiscard]] std::span<const float> pixel(size_t p) const {
    return std::span(image.samples)
        .subspan(image.first[p] * DeepImage::components,
                 (image.first[p + 1] - image.first[p]) * DeepImage::components);
  }
};

// Returns red, green, blue and opacity of what lies in front of z, by OpenEXR's rule for cutting a sample.
std::array<double, 4> flatten(std::span<const float> samples, double z) {
  std::array<double, 4> sum{};
  for (size_t n = 0; n < samples.size() && samples[n] < z; n += DeepImage::components) {
    const double front = samples[n], back = samples[n + 1];
    const double alpha = samples[n + 2];
    const double part = back > z ? (z - front) / (back - front) : 1;
    const double cut = part < 1 ? -std::expm1(part * std::log1p(-std::min(alpha, 1 - 1e-12))) : alpha;
    const double passed = 1 - sum[3];
    for (size_t c = 0; c < 3; ++c) sum[c] += passed * samples[n + 3 + c] * (alpha > 0 ? cut / alpha : 1);
    sum[3] += passed * cut;
  }
  return sum;
}

class DeepPicture : public testing::Test {
 protected:
  DeepPicture() : slice(test::make_slice({24, 20, 22}, test::marschner_lobb(24, 2))) {
    scene = test::make_scene(slice, test::ramp_function(0.35, 0.8, 0.5), {});
    look(false);
    options.deep_tolerance = 0.001;
  }
  void look(bool perspective) { scene.camera = fit_camera(slice, perspective, 20, 30, width, height); }
  void take(Deep& deep, int threads = 2) const { deep.draw(scene, options, threads); }

  // Expects tidy samples that are the flat picture when composited.
  void expect_flat(const Deep& deep, double error = 1e-5) {
    uint64_t seen = 0;
    for (size_t p = 0; p < size_t{width} * height; ++p) {
      const auto samples = deep.pixel(p);
      double last = -std::numeric_limits<double>::infinity();
      for (size_t n = 0; n < samples.size(); n += DeepImage::components) {
        const double front = samples[n], back = samples[n + 1];
        ASSERT_GE(front, last) << p;
        ASSERT_GE(back, front) << p;
        ASSERT_TRUE(back > front || front > last || n == 0) << p << ": a point on a point";
        ASSERT_GT(samples[n + 2], 0) << p;
        ASSERT_LE(samples[n + 2], 1) << p;
        last = back;
      }
      const auto flat = flatten(samples, std::numeric_limits<double>::infinity());
      for (size_t c = 0; c < 4; ++c) ASSERT_NEAR(flat[c], deep.flat.rgba[4 * p + c], error) << p;
      seen += samples.empty() ? 0u : 1u;
    }
    EXPECT_GT(seen, 300u);
  }

  Slice slice;
  Scene scene;
  RenderOptions options;
};

TEST_F(DeepPicture, FlattensToTheFlatPicture) {
  for (const bool perspective : {false, true})
    for (const double tolerance : {no_merging, 0.001, 0.05})
      for (const double stop : {0.995, 1.0}) {
        look(perspective);
        options.deep_tolerance = tolerance, options.opacity_stop = stop;
        Deep deep;
        take(deep);
        expect_flat(deep);
      }
}

TEST_F(DeepPicture, DoesNotChangeTheFlatPicture) {
  Deep deep;
  take(deep);
  ImageStorage alone(width, height, true);
  (void)draw(scene, options, alone);
  EXPECT_EQ(alone.rgba, deep.flat.rgba);
  EXPECT_EQ(alone.depth, deep.flat.depth);
}

TEST_F(DeepPicture, DependsNeitherOnTilesNorThreads) {
  Deep a, b;
  options.tile_size = 64;
  take(a, 1);
  options.tile_size = 16;
  take(b, 3);
  EXPECT_EQ(a.image.first, b.image.first);
  EXPECT_EQ(a.image.samples, b.image.samples);
}

TEST_F(DeepPicture, PassesOneHalfAtTheDepthOfTheFlatPicture) {
  options.deep_tolerance = no_merging;
  for (const bool perspective : {false, true}) {
    look(perspective);
    Deep deep;
    take(deep);
    int passed = 0;
    for (size_t p = 0; p < size_t{width} * height; ++p) {
      const double depth = deep.flat.depth[p];
      if (!std::isfinite(depth)) continue;
      ++passed;
      EXPECT_NEAR(flatten(deep.pixel(p), depth)[3], 0.5, 1e-3) << p;
    }
    EXPECT_GT(passed, 200);
  }
}

TEST_F(DeepPicture, MergingStaysWithinItsToleranceAtEveryCut) {
  Deep all;
  options.deep_tolerance = no_merging;
  take(all);
  uint64_t before = all.image.first.back();
  for (const double tolerance : {0.001, 0.01, 0.1}) {
    Deep merged;
    options.deep_tolerance = tolerance;
    take(merged);
    EXPECT_LT(merged.image.first.back(), before * 3 / 4) << tolerance;
    before = merged.image.first.back();
    double most = 0;
    for (size_t p = 0; p < size_t{width} * height; ++p) {
      const auto samples = all.pixel(p);
      for (size_t n = 0; n < samples.size(); n += DeepImage::components) {
        const auto a = flatten(samples, samples[n + 1]);
        const auto b = flatten(merged.pixel(p), samples[n + 1]);
        for (size_t c = 0; c < 4; ++c) most = larger(most, std::fabs(a[c] - b[c]));
      }
    }
    EXPECT_LT(most, 1.01 * tolerance + 1e-5);
    EXPECT_GT(most, 0.2 * tolerance); // it is used
  }
}

TEST_F(DeepPicture, ASurfaceIsOneOpaquePoint) {
  options.mode = RenderMode::isosurface, options.iso_value = 0.5;
  for (const bool perspective : {false, true}) {
    look(perspective);
    Deep deep;
    take(deep);
    expect_flat(deep, 1e-6);
    for (size_t p = 0; p < size_t{width} * height; ++p) {
      const auto s = deep.pixel(p);
      const bool hit = deep.flat.rgba[4 * p + 3] > 0;
      ASSERT_EQ(s.size(), hit ? DeepImage::components : 0);
      if (!hit) continue;
      EXPECT_EQ(s[0], s[1]);
      EXPECT_EQ(s[0], deep.flat.depth[p]);
      EXPECT_EQ(s[2], 1);
    }
  }
}

// What a clip leaves of the samples behind z.
std::array<double, 4> behind(std::span<const float> samples, double z) {
  std::array<double, 4> sum{};
  for (size_t n = 0; n < samples.size(); n += DeepImage::components) {
    const double front = samples[n], back = samples[n + 1];
    if (back <= z) continue;
    const double alpha = samples[n + 2];
    const double part = front < z ? (back - z) / (back - front) : 1;
    const double cut = part < 1 ? -std::expm1(part * std::log1p(-std::min(alpha, 1 - 1e-12))) : alpha;
    const double passed = 1 - sum[3];
    for (size_t c = 0; c < 3; ++c) sum[c] += passed * samples[n + 3 + c] * cut / alpha;
    sum[3] += passed * cut;
  }
  return sum;
}

// The scene seen along z, and the same scene without what lies in front of a depth.
class Uncovered : public DeepPicture {
 protected:
  Uncovered() {
    scene.camera = fit_camera(slice, false, 0, 0, width, height);
    options.opacity_stop = 1;
  }
  [[nodiscard]] double depth_of(double z) const { // of a plane in slice space; the world is slice space
    return z - scene.camera.position[2];
  }
  void draw_behind(double z, ImageStorage& out) {
    Slice cut = slice;
    const double lattice_z = slice.lattice_to_slice.inverse().point({0, 0, z})[2];
    cut.clip.push_back({{0, 0, 1}, -lattice_z});
    Scene of_cut = scene;
    of_cut.slice = &cut;
    RenderOptions o = options;
    o.smooth_edges = false;
    (void)draw(of_cut, o, out);
  }
};

TEST_F(Uncovered, WhatLiesBehindDenseMatterIsThere) {
  uint64_t merged[2] = {};
  for (const auto& [opacity, tolerance] :
       {std::pair(0.97, 0.001), std::pair(0.2, no_merging), std::pair(0.2, 0.001)}) {
    scene.function = test::ramp_function(0.2, 0.6, opacity);
    options.deep_tolerance = tolerance;
    Deep deep;
    take(deep);
    expect_flat(deep);
    if (opacity < 0.5) merged[tolerance > no_merging] = deep.image.first.back();
    for (const double z : {4.0, 9.3, 15.2}) {
      ImageStorage expected(width, height);
      draw_behind(z, expected);
      ImageStorage uncovered(width, height);
      uint64_t dense = 0;
      for (size_t p = 0; p < size_t{width} * height; ++p) {
        const auto sum = behind(deep.pixel(p), depth_of(z));
        for (size_t c = 0; c < 4; ++c) uncovered.rgba[4 * p + c] = static_cast<float>(sum[c]);
        dense += deep.flat.rgba[4 * p + 3] == 1 && sum[3] > 0.1 ? 1u : 0u;
      }
      EXPECT_GE(dense, opacity > 0.5 ? 100u : 0u); // floats saturate long before the far end
      EXPECT_GT(test::compare(uncovered, expected).db(), 55) << z << ", tolerance " << tolerance;
    }
  }
  EXPECT_LT(merged[1], merged[0]);
}

TEST_F(Uncovered, EverySurfaceOfARayIsThere) {
  slice = test::make_slice({24, 20, 22}, [](double x, double y, double z) {
    return 0.5 + 0.4 * std::sin(0.9 * z + 0.2 * x) * std::cos(0.1 * y);
  });
  options.mode = RenderMode::isosurface, options.iso_value = 0.5;
  Deep deep;
  take(deep);
  expect_flat(deep, 1e-6);
  uint64_t several = 0;
  for (size_t p = 0; p < size_t{width} * height; ++p) several += deep.pixel(p).size() > 12 ? 1u : 0u;
  EXPECT_GT(several, 100u);
  for (const double z : {4.0, 9.3, 15.2}) {
    ImageStorage expected(width, height, true);
    draw_behind(z, expected);
    uint64_t hits = 0, other = 0; // at edges a ray may or may not graze
    for (size_t p = 0; p < size_t{width} * height; ++p) {
      float next = std::numeric_limits<float>::infinity();
      const auto samples = deep.pixel(p);
      for (size_t n = 0; n < samples.size() && std::isinf(next); n += DeepImage::components) {
        EXPECT_EQ(samples[n], samples[n + 1]);
        EXPECT_EQ(samples[n + 2], 1);
        if (samples[n] > depth_of(z)) next = samples[n];
      }
      hits += std::isfinite(next) ? 1u : 0u;
      other += next == expected.depth[p] || std::fabs(next - expected.depth[p]) < 0.02f ? 0u : 1u;
    }
    EXPECT_GT(hits, 300u) << z;
    EXPECT_LT(other, hits / 50) << z;
  }
}

TEST_F(Uncovered, ARayEndsAtTheLastSurfaceItHasRoomFor) {
  slice = test::make_slice({8, 8, 200}, [](double, double, double z) { return std::sin(1.4 * z); });
  scene.camera = fit_camera(slice, false, 0, 0, width, height);
  options.mode = RenderMode::isosurface, options.iso_value = 0.1;
  Deep deep;
  take(deep);
  size_t most = 0;
  for (size_t p = 0; p < size_t{width} * height; ++p)
    most = std::max(most, deep.pixel(p).size() / DeepImage::components);
  EXPECT_EQ(most, size_t{most_surfaces});
}

TEST_F(DeepPicture, IsLitLikeThePlainOneWhereGradientsAreNoise) {
  options.shading = true;
  std::vector<float> before;
  for (const GradientNoise noise : {GradientNoise{}, GradientNoise{0.05, 0}, GradientNoise{0, 0.4}}) {
    scene.lights.noise = noise;
    for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface}) {
      options.mode = mode, options.iso_value = 0.5, options.smooth_edges = false;
      options.rays = false; // which draw nothing deep
      ImageStorage plain(width, height);
      (void)draw(scene, options, plain);
      Deep deep;
      take(deep);
      expect_flat(deep);
      EXPECT_EQ(plain.rgba, deep.flat.rgba);
      if (mode == RenderMode::composite) {
        EXPECT_NE(plain.rgba, before); // the noise is seen at all
        before = plain.rgba;
      }
    }
  }
}

TEST_F(DeepPicture, HasNoSamplesInHoles) {
  for (auto& layer : slice.coset)
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      auto brick = std::make_shared<Brick>();
      brick->value = layer.brick(s)->value, brick->kept = layer.brick(s)->kept;
      brick->hole = std::make_unique<BrickMask>();
      brick->hole->fill(0x000f); // sites 0 to 3 of each row
      layer.set(s, std::move(brick));
    }
  slice.has_holes = true;
  options.deep_tolerance = no_merging;
  Deep deep;
  take(deep);
  expect_flat(deep);
  Deep whole;
  slice.has_holes = false;
  take(whole);
  EXPECT_LT(deep.image.first.back(), whole.image.first.back() * 7 / 8);
}

TEST(DeepTrail, FlattensToTheFlatPicture) {
  test::TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {24, 20, 17, 16});
  const auto samples = test::sample_field(lattice, [](const Vec4& p) {
    const double x = p[0] - 6 - 0.8 * p[3], y = p[1] - 9, z = p[2] - 8;
    return std::exp(-(x * x + y * y + z * z) / 18);
  });
  const Coefficients coefficients(samples, 0, make_kernel("default"), 0, 1u << 30);
  const Slice slice = time_slice(coefficients, 12, {0, 0}, {}, context.get());
  const Trail trail =
      make_trail(coefficients, slice, {.interval = {-8, 0}, .samples = 6}, {}, {}, context.get());
  Scene scene = test::make_scene(slice, test::ramp_function(0.3, 0.9, 0.8),
                                 fit_camera(slice, false, 20, 30, width, height));
  scene.trail = &trail, scene.trail_functions = {test::ramp_function(0.1, 0.9, 0.3)};
  RenderOptions options;
  for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface})
    for (const TrailCombine combine : {TrailCombine::physical, TrailCombine::interleaved}) {
      options.mode = mode, options.iso_value = 0.6, scene.combine = combine;
      Deep deep;
      deep.draw(scene, options);
      uint64_t surfaces = 0, several = 0;
      for (size_t p = 0; p < size_t{width} * height; ++p) {
        const auto s = deep.pixel(p);
        const auto flat = flatten(s, std::numeric_limits<double>::infinity());
        for (size_t c = 0; c < 4; ++c) ASSERT_NEAR(flat[c], deep.flat.rgba[4 * p + c], 1e-5) << p;
        if (s.empty()) continue;
        surfaces += s[s.size() - 6] == s[s.size() - 5] && s[s.size() - 4] == 1 ? 1u : 0u;
        several += s.size() > 6 ? 1u : 0u;
      }
      EXPECT_GT(several, 100u);
      // By equation (8) a surface is segments that rays go through.
      EXPECT_EQ(surfaces > 20, mode == RenderMode::isosurface && combine == TrailCombine::physical);
    }
}

TEST_F(DeepPicture, IsRefusedWhereThereIsNoOrderInDepth) {
  Deep deep;
  const auto code = [&] {
    try {
      deep.draw(scene, options);
    } catch (const Error& e) {
      return e.code();
    }
    return Code::ok;
  };
  options.shading = false;
  EXPECT_EQ(code(), Code::ok);
  options.mode = RenderMode::maximum;
  EXPECT_EQ(code(), Code::unsupported);
  options.mode = RenderMode::xray;
  EXPECT_EQ(code(), Code::unsupported);
  options.mode = RenderMode::composite, options.reference = true;
  EXPECT_EQ(code(), Code::unsupported);
}

TEST_F(DeepPicture, CountsAgainstTheMemoryBudget) {
  Deep deep;
  take(deep);
  const uint64_t bytes = deep.image.samples.size() * sizeof(float);
  Tasks tasks(1);
  Progress progress;
  MemoryBudget enough(4 * bytes), scarce(bytes / 2);
  ImageStorage flat(width, height);
  flat.image.deep = &deep.image;
  (void)render(scene, options, Context{tasks, enough, progress}, flat.image);
  EXPECT_GE(enough.used(), bytes);
  deep.image = {};
  EXPECT_EQ(enough.used(), 0u);
  try {
    (void)render(scene, options, Context{tasks, scarce, progress}, flat.image);
    FAIL() << "drawn in half of its size";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::memory_budget);
  }
  EXPECT_EQ(scarce.used(), 0u);
}

#if __has_include(<ImfDeepScanLineInputFile.h>)

TEST_F(DeepPicture, IsWhatOpenExrReadsAndComposites) {
  Deep deep;
  take(deep);
  const std::string path = testing::TempDir() + "deep.exr";
  ExrOptions exr;
  exr.overwrite = true;
  write_deep_exr(path, width, height, deep.image.first, deep.image.samples, exr);
  constexpr size_t pixels = size_t{width} * height;
  {
    Imf::DeepScanLineInputFile file(path.c_str());
    EXPECT_EQ(Imf::deepImageState(file.header()), Imf::DIS_TIDY);
    EXPECT_EQ(file.header().compression(), Imf::ZIPS_COMPRESSION);
    std::vector<uint32_t> counts(pixels);
    std::vector<std::array<std::vector<float>, 6>> samples(pixels);
    std::array<std::vector<float*>, 6> tables;
    const char* const names[] = {"Z", "ZBack", "A", "R", "G", "B"};
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), 4, size_t{4} * width));
    for (size_t c = 0; c < 6; ++c) {
      tables[c].resize(pixels);
      frame.insert(names[c], Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(tables[c].data()),
                                            sizeof(float*), sizeof(float*) * width, sizeof(float)));
    }
    file.setFrameBuffer(frame);
    file.readPixelSampleCounts(0, height - 1);
    for (size_t p = 0; p < pixels; ++p)
      for (size_t c = 0; c < 6; ++c) {
        samples[p][c].resize(counts[p]);
        tables[c][p] = samples[p][c].data();
      }
    file.readPixels(0, height - 1);
    for (size_t p = 0; p < pixels; ++p) {
      const auto expected = deep.pixel(p);
      ASSERT_EQ(counts[p] * DeepImage::components, expected.size());
      for (size_t n = 0; n < expected.size(); ++n)
        ASSERT_EQ(samples[p][n % DeepImage::components][n / DeepImage::components], expected[n]);
    }
  }
  // OpenEXR's own compositing must give the flat picture, too.
  Imf::DeepScanLineInputFile file(path.c_str());
  Imf::CompositeDeepScanLine composite;
  composite.addSource(&file);
  std::vector<float> rgba(4 * pixels);
  Imf::FrameBuffer frame;
  for (size_t c = 0; c < 4; ++c)
    frame.insert(std::string(1, "RGBA"[c]),
                 Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(rgba.data() + c), 16, size_t{16} * width));
  composite.setFrameBuffer(frame);
  composite.readPixels(0, height - 1);
  double most = 0;
  for (size_t n = 0; n < rgba.size(); ++n)
    most = larger(most, std::fabs(static_cast<double>(rgba[n]) - deep.flat.rgba[n]));
  EXPECT_LT(most, 1e-5);
  std::remove(path.c_str());
}

#endif

} // namespace
} // namespace bccsplat
