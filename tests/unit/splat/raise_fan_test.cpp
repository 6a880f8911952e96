// SPDX-License-Identifier: Apache-2.0
// Perspective out of sheets that are sampled side by side: the tables of raise_fan.h, and a camera inside the
// volume.
#include "splat/raise/raise_fan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

RaiseFan make_fan(int taps) {
  RaiseFan fan;
  fan.x = {1 / 600.0, 255.5}, fan.y = {1 / 450.0, -31.25};
  fan.taps = taps, fan.depth = 310.7, fan.nearest = 0.3, fan.border = 2;
  make_fan_weights(fan, 1.49);
  return fan;
}

// A pixel's weights are those of its place, to half a phase; and nobody's choice of the first pixel matters.
TEST(RaiseFan, WeightsAreThoseOfThePlace) {
  for (const int taps : {6, 8}) {
    const RaiseFan fan = make_fan(taps);
    for (const double k : {-200.0, 0.0, 117.0}) {
      RaiseAxis all, part;
      fan_axis(fan, fan.x, fan.scale(k), -2, 516, all);
      fan_axis(fan, fan.x, fan.scale(k), 97, 53, part);
      for (int i = 97; i < 150; ++i) {
        const auto n = static_cast<size_t>(i + 2), m = static_cast<size_t>(i - 97);
        ASSERT_EQ(all.sample[n], part.sample[m]);
        const double place = (k + 310.7) / 600 * (i - 255.5);
        const double phase = place - (all.sample[n] + taps / 2 - 1);
        ASSERT_GE(phase, -0.51 / RaiseFan::phases);
        ASSERT_LE(phase, 1);
        std::array<double, most_taps> expected{};
        raise_weights(taps, 0.5 / 1.49, phase, expected.data());
        for (int t = 0; t < taps; ++t) {
          const auto at = static_cast<size_t>(t);
          ASSERT_EQ(all.weight[at * all.pitch + n], part.weight[at * part.pitch + m]);
          ASSERT_NEAR(static_cast<double>(all.weight[at * all.pitch + n]), expected[at],
                      2.0 / RaiseFan::phases);
        }
      }
    }
  }
}

// On every sheet between two, the samples of pixels and their border are within fan_samples, and the pixels
// of those samples within fan_pixels.
TEST(RaiseFan, RangesHoldWhatIsNeeded) {
  const RaiseFan fan = make_fan(6);
  const Scales scales{fan.scale(-280), fan.scale(-140)};
  for (const auto& axis : {fan.x, fan.y})
    for (const int first : {-5, 100, 240, 400}) {
      const IntRange samples = fan_samples(fan, axis, scales, {first, first + 40});
      for (double k = -280; k <= -140; k += 20) {
        RaiseAxis exact;
        fan_axis(fan, axis, fan.scale(k), first - fan.border, 40 + 2 * fan.border, exact);
        EXPECT_LE(samples[0], exact.sample[0]);
        EXPECT_GE(samples[1], exact.sample[39 + 2 * static_cast<size_t>(fan.border)] + fan.taps);
        for (size_t n = 0; n < 44; ++n) {
          // Pixel n of the border or the tile looks at these; a pixel up to `border` away looks at it.
          const IntRange pixels = fan_pixels(fan, axis, scales, {exact.sample[n] + 2, exact.sample[n] + 3});
          const int pixel = first - fan.border + static_cast<int>(n);
          EXPECT_LE(pixels[0], pixel - fan.border);
          EXPECT_GT(pixels[1], pixel + fan.border);
        }
      }
    }
}

// Seen from inside, where the first sheet is magnified hundreds of times, the picture is near to that of
// sheets at the pixels, and no bit depends on tiles, threads or skips.
TEST(RaiseFan, CameraInsideTheVolume) {
  const Slice slice = make_slice({40, 36, 44}, marschner_lobb(44, 3));
  Camera camera;
  camera.perspective = true;
  camera.position = {14, 17, 12}, camera.target = {30, 22, 40}, camera.up = {0, 1, 0};
  camera.fovy_degrees = 40;
  const Scene scene = make_scene(slice, ramp_function(0.3, 1, 0.3), camera);
  RenderOptions o;
  o.sheet_step = 0.5, o.tile_size = 64, o.gradient = GradientMethod::fourth_order;
  o.raise = RaiseFilter{6, 1.49, 1.1, 1.1};
  ImageStorage raised(180, 170), other(180, 170);
  const RenderStats few = draw(scene, o, raised, 1);
  for (const auto& [tile, threads, skips] : {std::tuple{23, 2, 0u}, {200, 1, 0u}, {0, 3, 0u}, {64, 1, 79u}}) {
    o.tile_size = tile, o.disable_skips = skips;
    draw(scene, o, other, threads);
    EXPECT_EQ(std::memcmp(raised.rgba.data(), other.rgba.data(), other.rgba.size() * sizeof(float)), 0)
        << tile;
  }
  o.raise = RaiseFilter{};
  o.disable_skips = 0;
  const RenderStats many = draw(scene, o, other);
  EXPECT_LT(few.drawn.contributions, many.drawn.contributions / 3);
  double sum = 0;
  for (size_t n = 0; n < other.rgba.size(); ++n)
    sum += std::pow(static_cast<double>(raised.rgba[n]) - static_cast<double>(other.rgba[n]), 2);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(other.rgba.size())), 1e-2);
}

} // namespace
} // namespace bccsplat
