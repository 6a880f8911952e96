// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/motion_blobs.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "base/vec.h"

namespace bccsplat::bench {
namespace {

constexpr uint32_t frames = 8;

// A Gaussian, `width` its standard deviation.
struct Blob {
  Vec3 centre;
  double width, height;
};

std::vector<Blob> blobs_at(BlobWays ways, double speed, double edge, double t) {
  const double middle = (edge - 1) / 2, way = speed * (t - (frames - 1) / 2.0);
  const double width = edge / 20, twice = std::exp2(t / (frames - 1));
  std::vector<Blob> blobs;
  for (const int lane : {0, 1, 2, 3}) {
    const double y = lane & 1 ? edge * .7 : edge * .3, z = lane & 2 ? edge * .72 : edge * .28;
    const double forwards = lane == 0 || lane == 3 ? 1 : -1, height = 1 - .15 * lane;
    // Not along an axis, and of the speed that is asked for.
    const Vec3 along = normalized({1, .12 * (lane - 1.3), .1 * (1.6 - lane)});
    const auto moved = [&](double direction) { return Vec3{middle, y, z} + (direction * way) * along; };
    if (ways == BlobWays::apart) blobs.push_back({moved(forwards), width, height});
    if (ways == BlobWays::growing) blobs.push_back({moved(forwards), .75 * width * twice, height});
    if (ways == BlobWays::crossing)
      blobs.push_back({moved(1), width, height}), blobs.push_back({moved(-1), width, .8 * height});
    if (ways != BlobWays::circles || lane == 3) continue;
    const double radius = edge * (.2 + .06 * lane), level = edge * (.22 + .28 * lane);
    for (const double direction : {1., -1.}) {
      const double angle = direction * way / radius + lane;
      blobs.push_back({{middle + radius * std::cos(angle), middle + radius * std::sin(angle), level},
                       width,
                       height * (direction > 0 ? 1 : .8)});
    }
  }
  return blobs;
}

std::vector<float> frame_of(const std::vector<Blob>& blobs, uint32_t edge) {
  std::vector<float> values(size_t{edge} * edge * edge);
  for (const Blob& b : blobs) {
    std::array<std::vector<double>, 3> along; // each axis
    for (size_t a = 0; a < 3; ++a)
      for (uint32_t i = 0; i < edge; ++i)
        along[a].push_back(std::exp(-.5 * std::pow((i - b.centre[a]) / b.width, 2)));
    size_t n = 0;
    for (uint32_t z = 0; z < edge; ++z)
      for (uint32_t y = 0; y < edge; ++y)
        for (uint32_t x = 0; x < edge; ++x)
          values[n++] += static_cast<float>(b.height * along[0][x] * along[1][y] * along[2][z]);
  }
  return values;
}

} // namespace

std::string name_of(BlobWays ways) {
  constexpr const char* names[blob_ways] = {"apart", "growing", "crossing", "on circles"};
  return names[static_cast<size_t>(ways)];
}

MotionSet moving_blobs(BlobWays ways, double speed, uint32_t edge) {
  FitSeries series{{edge, edge, edge, frames}, {}};
  std::vector<LeftOut> left_out;
  for (uint32_t t = 0; t < frames; ++t) {
    const std::vector<float> frame = frame_of(blobs_at(ways, speed, edge, t), edge);
    series.values.insert(series.values.end(), frame.begin(), frame.end());
    if (t + 1 < frames) left_out.push_back({t + .5, frame_of(blobs_at(ways, speed, edge, t + .5), edge)});
  }
  const double peak = *std::max_element(series.values.begin(), series.values.end());
  constexpr double fast = 8, gain = 6; // voxels; dB
  const bool free = ways == BlobWays::apart || ways == BlobWays::growing;
  return {source_of<float>(series, SourceType::f32, 1, concat("blobs ", name_of(ways), ", ", speed)),
          even_times(frames), std::move(left_out), peak, free && speed >= fast ? gain : -most_lost};
}

} // namespace bccsplat::bench
