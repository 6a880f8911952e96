// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/deep.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bccsplat {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

float extinction(const DeepSample& s) {
  constexpr float opaque = 1e-30f;
  return -std::log(std::max(1 - s.alpha, opaque)) / (s.back - s.front);
}

std::array<float, 3> colors(const DeepSample& s) { return {s.red, s.green, s.blue}; }

} // namespace

void DeepTile::begin_tile(int width, int height, int pitch, double tolerance) {
  width_ = width, height_ = height, pitch_ = pitch;
  tolerance_ = static_cast<float>(tolerance);
  runs_.assign(static_cast<size_t>(pitch) * static_cast<size_t>(height), {});
  entries_.clear();
}

DeepSample DeepTile::sample_between(const Sum& before, const Sum& after, float front, float back) {
  const float passed = 1 - before[3];
  const auto part = [&](size_t n) { return (after[n] - before[n]) / passed; };
  return {front, back, std::min(part(3), 1.0f), part(0), part(1), part(2)};
}

void DeepTile::start_run(Run& run, float front) {
  constexpr Bounds any{-infinity, infinity};
  run.front = run.back = front;
  run.before = run.after;
  run.extinction = any;
  run.color = {any, any, any};
}

bool DeepTile::fits_run(const Run& run, const DeepSample& whole) {
  const auto inside = [](const Bounds& b, float x) { return x >= b.low && x <= b.high; };
  if (!inside(run.extinction, extinction(whole))) return false;
  const auto color = colors(whole);
  for (size_t c = 0; c < 3; ++c)
    if (!inside(run.color[c], color[c] / whole.alpha)) return false;
  return true;
}

// A sample that goes on beyond this cut must show there what `whole` shows: half of the tolerance goes to the
// opacity, half to the colour per opacity.
void DeepTile::limit_run(Run& run, const DeepSample& whole) const {
  const float off = 0.5f * tolerance_ / (1 - run.before[3]);
  const float length = whole.back - whole.front, passes = 1 - whole.alpha;
  const auto narrow = [](Bounds& b, float low, float high) {
    b.low = std::max(b.low, low), b.high = std::min(b.high, high);
  };
  narrow(run.extinction, -std::log(passes + off) / length,
         passes > off ? -std::log(passes - off) / length : infinity);
  const auto color = colors(whole);
  for (size_t c = 0; c < 3; ++c)
    narrow(run.color[c], (color[c] - off) / whole.alpha, (color[c] + off) / whole.alpha);
}

void DeepTile::close_run(Run& run, size_t p) {
  if (run.back > run.front)
    entries_.push_back(
        {static_cast<uint32_t>(p), sample_between(run.before, run.after, run.front, run.back)});
}

void DeepTile::add_segment(const PixelPlanes& planes, float front, float back, const PixelRect& seen) {
  const PixelRect rect = seen.within(width_, height_);
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x) {
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(pitch_) + static_cast<size_t>(x);
      Run& run = runs_[p];
      if (!(planes.alpha[p] > run.after[3])) continue;
      const Sum now = sum_of(planes, p);
      const float from = std::max(front, planes.enter[p]), to = std::min(back, planes.leave[p]);
      if (!(to > from)) { // the part is shorter than a float can tell
        run.after = now;
        continue;
      }
      const bool goes_on = run.back > run.front && run.back == from;
      if (!goes_on || !fits_run(run, sample_between(run.before, now, run.front, to))) {
        close_run(run, p);
        start_run(run, from);
      }
      run.back = to, run.after = now;
      limit_run(run, sample_between(run.before, now, run.front, to));
    }
}

void DeepTile::add_surface(const PixelPlanes& planes, size_t p, float k) {
  Run& run = runs_[p];
  close_run(run, p);
  entries_.push_back({static_cast<uint32_t>(p), sample_between(run.after, sum_of(planes, p), k, k)});
  run.after = sum_of(planes, p);
  start_run(run, k);
}

void DeepTile::finish_tile() {
  for (size_t p = 0; p < runs_.size(); ++p) close_run(runs_[p], p);
  const auto place = [&](uint32_t p) {
    const auto pitch = static_cast<size_t>(pitch_);
    return p / pitch * static_cast<size_t>(width_) + p % pitch;
  };
  counts_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), 0);
  for (const Entry& e : entries_) ++counts_[place(e.pixel)];
  std::vector<size_t> next(counts_.size());
  size_t sum = 0;
  for (size_t n = 0; n < counts_.size(); ++n) next[n] = sum, sum += counts_[n];
  samples_.resize(sum);
  for (const Entry& e : entries_) samples_[next[place(e.pixel)]++] = e.sample;
}

} // namespace bccsplat
