// SPDX-License-Identifier: Apache-2.0
#include "draw/deep.h"

#include <algorithm>
#include <array>
#include <limits>

namespace bccsplat {
namespace {

// One large page at most is touched between two checks: the system clears it first, for milliseconds.
constexpr uint64_t floats_per_check = large_page / sizeof(float) / 4;
constexpr size_t sample_bytes = DeepImage::components * sizeof(float);
using Sample = std::array<float, DeepImage::components>; // Z, ZBack, A, R, G, B

// Segments thinner than a float of world depth are points, and two points must not coincide.
bool coincide(const Sample& a, const Sample& b) { return a[0] == b[1] && a[1] == b[0] && a[0] == a[1]; }

void put_behind(float* front, const Sample& back) {
  const float passed = 1 - front[2];
  for (size_t c = 2; c < back.size(); ++c) front[c] += passed * back[c];
}

} // namespace

void DeepCollector::add(const TilePixels& tile, const SheetView& view, Progress& progress) {
  const auto samples = tile.deep->samples();
  const auto counts = tile.deep->counts();
  Part part{tile.x, tile.y, tile.width, tile.height, {}, {}, {}};
  part.memory =
      Reservation(memory_, samples.size() * sample_bytes + counts.size_bytes(), "render: deep samples");
  part.counts.assign(counts.begin(), counts.end());
  part.samples.reserve(samples.size() * DeepImage::components);
  // Nothing of a perspective picture is behind the camera, but by rounding.
  const double nearest = view.perspective ? 0 : -std::numeric_limits<double>::infinity();
  const auto depth = [&](float sheet) {
    return static_cast<float>(std::max(nearest, (sheet + view.depth) * view.step_world));
  };
  const DeepSample* next = samples.data();
  size_t checked = 0; // floats at the last check
  for (uint32_t& count : part.counts) {
    if (part.samples.size() - checked >= floats_per_check) progress.check(), checked = part.samples.size();
    Sample before{1, 0};
    uint32_t left = 0;
    for (uint32_t n = 0; n < count; ++n) {
      const DeepSample& s = *next++;
      const Sample now{depth(s.front), depth(s.back), s.alpha, s.red, s.green, s.blue};
      if (coincide(before, now)) {
        put_behind(part.samples.data() + part.samples.size() - now.size(), now);
        continue;
      }
      part.samples.insert(part.samples.end(), now.begin(), now.end());
      before = now, ++left;
    }
    count = left;
  }
  const std::scoped_lock lock(mutex_);
  parts_.push_back(std::move(part));
}

DeepImage DeepCollector::collect(int width, int height, Progress& progress) {
  DeepImage image;
  const auto columns = static_cast<size_t>(width), pixels = columns * height;
  uint64_t total = 0;
  for (const Part& part : parts_) total += part.samples.size();
  image.memory = Reservation(memory_, (pixels + 1) * sizeof(uint64_t) + total * sizeof(float),
                             "render: the deep picture");
  image.first.assign(pixels + 1, 0);
  const auto pixel = [&](const Part& part, size_t n) {
    const size_t w = part.width;
    return (part.y + n / w) * columns + part.x + n % w;
  };
  for (const Part& part : parts_) {
    progress.check();
    for (size_t n = 0; n < part.counts.size(); ++n) image.first[pixel(part, n) + 1] = part.counts[n];
  }
  for (size_t p = 0; p < pixels; ++p) image.first[p + 1] += image.first[p];
  image.samples.reserve(total);
  // Grows by steps, as clearing all of it takes long.
  for (uint64_t size = 0; size < total; image.samples.resize(size)) {
    progress.check();
    size = std::min(total, size + floats_per_check);
  }
  uint64_t copied = 0, checked = 0; // floats
  for (const Part& part : parts_) {
    const float* from = part.samples.data();
    for (size_t n = 0; n < part.counts.size(); ++n) {
      if (copied - checked >= floats_per_check) progress.check(), checked = copied;
      const size_t floats = part.counts[n] * DeepImage::components;
      std::copy_n(from, floats, image.samples.data() + image.first[pixel(part, n)] * DeepImage::components);
      from += floats, copied += floats;
    }
  }
  parts_.clear();
  return image;
}

} // namespace bccsplat
