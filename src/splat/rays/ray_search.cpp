// SPDX-License-Identifier: Apache-2.0
// Rays go on slab by slab in squares of pixels, so that samples lie side by side: all samples that a slab
// asks for are summed at once. Between samples beside each other a ray looks for a change of side, and for a
// turn that may pass the value twice; both ends of what it looks at lie on whole sheets, so that cells which
// are passed over change nothing that it finds.
#include "splat/rays/ray_search.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// A root may lie this far outside of its ray's part of the domain, sheets.
constexpr double outside_tolerance = 1e-5;

// The whole number below a sheet number.
int below(double k) {
  constexpr int lift = 1 << 24;
  return static_cast<int>(k + lift) - lift;
}

} // namespace

RaySearch::RaySearch(const RayField& of) : f_(of), view_(*of.view), way_(*of.way) {
  const size_t room = pixels * way_.most_sheets();
  samples_.resize(room), places_.resize(room), values_.resize(room), gradients_.resize(room);
}

uint64_t RaySearch::buffers(const RayWay& way) {
  constexpr uint64_t sample = sizeof(int) + sizeof(Vec4) + sizeof(float) + sizeof(std::array<float, 4>);
  constexpr uint64_t ray = sizeof(uint32_t) + sizeof(Part) + sizeof(uint32_t) + sizeof(RayHit);
  return pixels * (way.most_sheets() * sample + ray);
}

std::span<const RayHit> RaySearch::find(int x, int y, int width, int height, Progress& progress) {
  hits_.clear();
  x_ = x, y_ = y;
  begin(width, height);
  while (!open_.empty()) {
    progress.check();
    int slab = ray_[open_[0]].slab;
    for (const uint32_t r : open_) slab = std::min(slab, ray_[r].slab);
    count_ = 0, parts_.clear();
    for (const uint32_t r : open_)
      if (ray_[r].slab == slab) ask(r);
    search();
    std::erase_if(open_, [&](uint32_t r) {
      if (ray_[r].slab != slab) return false;
      ++ray_[r].slab; // hits have ended theirs
      layers_[r] = way_.advance(ray_[r]);
      return layers_[r] == 0;
    });
  }
  counts_.hits += hits_.size();
  return hits_;
}

void RaySearch::begin(int width, int height) {
  open_.clear();
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      if (!way_.any(x_ + i, y_ + j)) continue;
      const auto r = static_cast<uint32_t>(j * square + i);
      if (!way_.begin(x_ + i, y_ + j, ray_[r])) continue;
      last_[r] = {};
      layers_[r] = way_.advance(ray_[r]);
      if (layers_[r] != 0) open_.push_back(r);
    }
}

// Notes the sheets that the ray's layers lie between and that it has not looked at yet.
void RaySearch::ask(uint32_t r) {
  const RayWay::Ray& ray = ray_[r];
  const Vec3 at = ray.at, ez = view_.ez;
  const uint32_t first = count_;
  uint32_t count = first;
  int next = last_[r].k + 1;
  way_.each_run(ray, layers_[r], [&](double from, double to) {
    from = std::max(from, ray.enter), to = std::min(to, ray.leave);
    if (to < from) return;
    const int low = std::max(below(from), next), high = -below(-to);
    for (int k = low; k <= high; ++k, ++count) {
      samples_[count] = k;
      places_[count] = {at[0] + k * ez[0], at[1] + k * ez[1], at[2] + k * ez[2], 0};
    }
    next = std::max(next, high + 1);
  });
  count_ = count;
  if (count > first) parts_.push_back({r, first, count});
}

void RaySearch::search() {
  if (count_ == 0) return;
  counts_.samples += count_;
  sum_footprints(f_.field->footprints, std::span(places_).first(count_), values_.data(), gradients_.data());
  scanned_.resize(parts_.size());
  for (uint32_t p = 0; p < scanned_.size(); ++p) scanned_[p] = p;
  while (!scanned_.empty()) {
    crossings_.clear(), grazes_.clear();
    for (const uint32_t p : scanned_) scan(p);
    scanned_.clear();
    settle();
  }
}

// Goes on along the samples of a part until something is found: the sides of two neighbours differ, or the
// field comes closer, goes away, and the tangents meet beyond the target. What is asked of each pair is
// decided by one branch, which is hardly ever taken.
void RaySearch::scan(uint32_t p) {
  Part& part = parts_[p];
  const Vec3 ez = view_.ez;
  const double target = f_.target;
  Station before = last_[part.ray];
  bool found = false;
  uint32_t n = part.next;
  for (; n < part.end && !found; ++n) {
    const auto& g = gradients_[n];
    const double slope = static_cast<double>(g[0]) * ez[0] + static_cast<double>(g[1]) * ez[1] +
                         static_cast<double>(g[2]) * ez[2];
    const Station here{samples_[n], static_cast<double>(values_[n]), slope};
    const double d0 = before.value - target, d1 = here.value - target;
    const double side = std::copysign(1.0, -d0), s0 = side * before.slope, s1 = side * slope;
    const bool crosses = (d0 < 0) != (d1 < 0);
    const bool grazes = (s0 > 0) & (s1 < 0) & (side * d0 * (s0 - s1) + s0 * (side * (d1 - d0) - s1) > 0);
    if ((before.k == here.k - 1) & (crosses | grazes)) {
      const double i = x_ + static_cast<int>(part.ray % square), j = y_ + static_cast<int>(part.ray / square);
      (crosses ? crossings_ : grazes_)
          .push_back({i, j, 1.0 * before.k, 1.0 * here.k, before.value, here.value, before.slope, slope, p});
      found = true;
    }
    before = here;
  }
  part.next = n;
  last_[part.ray] = before;
}

// Refines what was found; parts for which that was nothing are scanned on.
void RaySearch::settle() {
  if (!grazes_.empty()) {
    counts_.grazes += grazes_.size();
    const auto found = find_grazes(*f_.field, view_, f_.target, grazes_);
    passed_.assign(parts_.size(), 0);
    for (const Crossing& c : found) passed_[c.number] = 1;
    for (const Crossing& c : grazes_)
      if (passed_[c.number] == 0) scanned_.push_back(c.number);
    crossings_.insert(crossings_.end(), found.begin(), found.end());
  }
  if (crossings_.empty()) return;
  const auto points = refine_crossings(*f_.field, view_, f_.target, crossings_, root_tolerance);
  for (size_t n = 0; n < points.size(); ++n) {
    const Crossing& c = crossings_[n];
    RayWay::Ray& ray = ray_[parts_[c.number].ray];
    if (points[n].k < ray.enter - outside_tolerance || points[n].k > ray.leave + outside_tolerance) {
      scanned_.push_back(c.number);
      continue;
    }
    hits_.push_back({static_cast<int>(c.i), static_cast<int>(c.j), points[n]});
    ray.end = 0;
  }
}

} // namespace bccsplat
