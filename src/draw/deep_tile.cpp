// SPDX-License-Identifier: Apache-2.0
// Makes samples of what successive sheets add to a pixel, merges neighbours as far as they look alike, and
// sorts them by pixel in the end.
#include "draw/deep_tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/grid.h"

namespace bccsplat {
namespace {

constexpr float unbounded = std::numeric_limits<float>::infinity();
// Such a pixel is never finished. What passes less than 1/100 is a float of the opacity to within 6e-6 of
// itself.
constexpr float opaque_front = 0.99f;
// A sample that is cut off in front shows what passes it divided by what passes the part that is gone.
constexpr float opaque_sample = 0.5f;
constexpr size_t samples_per_check = 1 << 17; // less than a millisecond

float extinction(const DeepSample& s) {
  constexpr float opaque = 1e-30f;
  return -std::log(std::max(1 - s.alpha, opaque)) / (s.back - s.front);
}

std::array<float, 3> colors(const DeepSample& s) { return {s.red, s.green, s.blue}; }

} // namespace

void DeepTile::begin_tile(int width, int height, int pitch, double tolerance, bool never_finished) {
  width_ = width, height_ = height, pitch_ = pitch;
  tolerance_ = static_cast<float>(tolerance);
  runs_.assign(plane_size(pitch, height), {});
  fronts_.assign(never_finished ? runs_.size() : 0, {});
  entries_.clear();
}

DeepSample DeepTile::sample_between(const Sum& before, const Sum& after, float front, float back) {
  const float passed = 1 - before[3];
  const auto part = [&](size_t n) { return (after[n] - before[n]) / passed; };
  return {front, back, std::min(part(3), 1.0f), part(0), part(1), part(2)};
}

void DeepTile::start_run(Run& run, float front) {
  constexpr Bounds any{-unbounded, unbounded};
  run.front = run.back = front;
  run.before = run.after;
  run.extinction = any;
  run.color = {any, any, any};
}

bool DeepTile::fits_run(const Run& run, const DeepSample& whole) const {
  if (!fronts_.empty() && whole.alpha > opaque_sample) return false;
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
  const float off = 0.5f * tolerance_ / (fronts_.empty() ? 1 - run.before[3] : 1);
  const float length = whole.back - whole.front, passes = 1 - whole.alpha;
  const auto narrow = [](Bounds& b, float low, float high) {
    b.low = std::max(b.low, low), b.high = std::min(b.high, high);
  };
  narrow(run.extinction, -std::log(passes + off) / length,
         passes > off ? -std::log(passes - off) / length : unbounded);
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
      const size_t p = plane_index(x, y, pitch_);
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
      if (!fronts_.empty() && now[3] >= opaque_front) take_off(planes, p);
    }
}

void DeepTile::take_off(const PixelPlanes& planes, size_t p) {
  Run& run = runs_[p];
  close_run(run, p);
  Front& f = fronts_[p];
  const auto move = [&](float& sum, float* plane) {
    if (plane) sum += f.passes * plane[p], plane[p] = 0;
  };
  move(f.red, planes.red), move(f.green, planes.green), move(f.blue, planes.blue);
  move(f.value, planes.value), move(f.time, planes.time);
  if (!f.any) f.depth = planes.depth[p];
  f.any = true;
  f.passes *= 1 - planes.alpha[p];
  planes.alpha[p] = 0;
  run.after = {};
  start_run(run, run.back);
}

void DeepTile::put_fronts_back(const PixelPlanes& planes) const {
  for (size_t p = 0; p < fronts_.size(); ++p) {
    const Front& f = fronts_[p];
    if (!f.any) continue;
    const auto join = [&](float sum, float* plane) {
      if (plane) plane[p] = sum + f.passes * plane[p];
    };
    join(f.red, planes.red), join(f.green, planes.green), join(f.blue, planes.blue);
    join(f.value, planes.value), join(f.time, planes.time);
    planes.alpha[p] = 1 - f.passes * (1 - planes.alpha[p]);
    planes.depth[p] = f.depth;
  }
}

bool DeepTile::add_surface(const PixelPlanes& planes, size_t p, float k, float stop) {
  Run& run = runs_[p];
  close_run(run, p);
  entries_.push_back({static_cast<uint32_t>(p), sample_between(run.after, sum_of(planes, p), k, k)});
  run.after = sum_of(planes, p);
  start_run(run, k);
  if (fronts_.empty()) return planes.alpha[p] >= stop;
  if (++fronts_[p].surfaces == most_surfaces) return true;
  if (planes.alpha[p] >= opaque_front) take_off(planes, p);
  return false;
}

void DeepTile::finish_tile(Progress& progress) {
  for (size_t p = 0; p < runs_.size(); ++p) close_run(runs_[p], p);
  const auto place = [&](uint32_t p) {
    const size_t pitch = pitch_;
    return p / pitch * width_ + p % pitch;
  };
  counts_.assign(plane_size(width_, height_), 0);
  for (const Entry& e : entries_) ++counts_[place(e.pixel)];
  std::vector<size_t> next(counts_.size());
  size_t sum = 0;
  for (size_t n = 0; n < counts_.size(); ++n) next[n] = sum, sum += counts_[n];
  samples_.clear();
  samples_.reserve(sum);
  for (size_t size = 0; size < sum; samples_.resize(size)) {
    progress.check();
    size = std::min(sum, size + samples_per_check);
  }
  for (size_t n = 0; n < entries_.size(); ++n) {
    if (n % samples_per_check == 0) progress.check();
    samples_[next[place(entries_[n].pixel)]++] = entries_[n].sample;
  }
}

} // namespace bccsplat
