// SPDX-License-Identifier: Apache-2.0
// A ball that stands still and one that runs past it, and pictures of their trails.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "field/slice.h"
#include "scene/picture.h"
#include "scene/trail.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"

namespace bccsplat::test {

inline double ball(double x, double y, double z, double r) {
  return std::exp(-(x * x + y * y + z * z) / (2 * r * r));
}

// A ball that stands still at z = 8 (value 1), and one that runs along x past it, in front (z = 3) or behind
// (z = 13).
inline MemorySamples passing(double z) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {32, 16, 17, 24});
  return sample_field(lattice, [z](const Vec4& p) {
    return ball(p[0] - 16, p[1] - 8, p[2] - 8, 1.8) + 0.5 * ball(p[0] - 5 - p[3], p[1] - 8, p[2] - z, 1.6);
  });
}

// Everything the pictures of one series share. The view looks along +z, 48 x 24 pixels, 1.5 to a T.
class TrailPicture : public testing::Test {
 protected:
  static constexpr int width = 48, height = 24;

  explicit TrailPicture(double z = 3) : TrailPicture(passing(z)) {}
  explicit TrailPicture(MemorySamples&& series)
      : samples(std::move(series)), coefficients(samples, 0, make_kernel("default"), 0, large_cache) {
    options.shading = false;
    options.opacity_stop = 1;
    camera.position = {15.5, 7.5, -50}, camera.target = {15.5, 7.5, 8}, camera.up = {0, -1, 0},
    camera.ortho_height = 16;
    // The standing ball is dense and red, what is fainter is thin and green.
    solid.colors = {{0, {1, 0, 0}}}, solid.opacities = {{0.55, 0}, {0.75, 0.95}};
    thin.colors = {{0, {0, 1, 0}}}, thin.opacities = {{0.1, 0}, {0.45, 0.6}};
  }

  std::vector<float> draw(const Slice& slice, const TransferFunction& function, const Trail& trail = {},
                          TrailCombine combine = TrailCombine::physical, std::vector<float>* time = nullptr) {
    Scene scene;
    scene.slice = &slice, scene.camera = camera, scene.function = function, scene.combine = combine;
    scene.trail = &trail, scene.trail_functions = {thin};
    ImageStorage image(width, height, true, true, true);
    (void)render(scene, options, context.get(), image.image);
    if (time) *time = image.time;
    return image.rgba;
  }
  Slice still(double frame) { return time_slice(coefficients, frame, {0, 0}, {}, context.get()); }
  Trail trail(const Slice& s, const TrailOptions& o) {
    return make_trail(coefficients, s, o, {}, {}, context.get());
  }
  static const float* at(const std::vector<float>& rgba, int x, int y) {
    return rgba.data() + 4 * (y * width + x);
  }

  TestContext context;
  MemorySamples samples;
  Coefficients coefficients;
  RenderOptions options;
  Camera camera;
  TransferFunction solid, thin;
};

// Returns the trail with a slice of its own for every moment.
inline Trail stills_of(const Trail& trail, const Coefficients& coefficients, const Context& context) {
  Trail stills;
  stills.moments = trail.moments, stills.bounds = trail.bounds;
  for (TrailMoment& m : stills.moments) {
    m.shares = {{static_cast<uint32_t>(stills.sources.size()), 1.0f}};
    TrailSource source;
    source.slice = time_slice(coefficients, m.frame, {0, 0}, {}, context);
    source.points = make_points(source.slice, context);
    stills.sources.push_back(std::move(source));
  }
  return stills;
}

} // namespace bccsplat::test
