// SPDX-License-Identifier: Apache-2.0
#include "rays/ray_roots.h"

#include "shade/surface.h"

namespace bccsplat {
namespace {

constexpr int most_steps = 3;

} // namespace

RayRoots::RayRoots(const FootprintPlan& field, float target) : field_(field) {
  args_.ray = steps_.data();
  args_.target = target;
  // The root gets the gradient of the field's last sample: no further from it than where sheets draw, so that
  // finer sheets make the light better, too.
  args_.tolerance = static_cast<float>(root_tolerance);
}

void RayRoots::add(const RootPair& pair) {
  const size_t n = count_++;
  const auto set = [&](RootLanes::End& to, float x, const RootEnd& from) {
    to.x[n] = x, to.value[n] = from.value, to.slope[n] = from.slope;
  };
  set(lanes_.low, 0, pair.low), set(lanes_.high, 1, pair.high);
  rays_[n] = {pair.origin, pair.ray, pair.sheet, pair.number};
}

std::span<const RayRoot> RayRoots::find() {
  found_ = 0;
  args_.count = count_;
  guess_roots(args_, lanes_);
  for (int step = 0; count_ > 0; ++step) {
    for (size_t n = 0; n < count_; ++n) {
      const Vec3 &at = rays_[n].origin, &ray = rays_[n].ray;
      const double k = rays_[n].sheet + static_cast<double>(lanes_.next[n]);
      for (size_t a = 0; a < 3; ++a)
        places_[n][a] = at[a] + k * ray[a], steps_[n][a] = static_cast<float>(ray[a]);
    }
    sum_footprints(field_, std::span(places_).first(count_), values_.data(), gradients_.data());
    args_.count = count_;
    bracket_roots(args_, values_, gradients_, lanes_);
    take_roots(step + 1 == most_steps);
  }
  return std::span(roots_).first(found_);
}

void RayRoots::take_roots(bool last) {
  size_t left = 0;
  for (size_t n = 0; n < count_; ++n) {
    const Ray ray = rays_[n];
    if (last || (lanes_.near[n / 64] >> n % 64 & 1) != 0) {
      RayRoot& root = roots_[found_++];
      root.k = ray.sheet + static_cast<double>(lanes_.next[n]);
      for (size_t a = 0; a < 3; ++a) root.position[a] = ray.origin[a] + root.k * ray.ray[a];
      const Vec4& p = places_[n];
      root.sample.position = {p[0], p[1], p[2]}, root.sample.value = values_[n];
      for (size_t a = 0; a < 3; ++a) root.sample.gradient[a] = gradients_[n][a];
      root.number = ray.number;
      continue;
    }
    const auto move = [&](RootLanes::End& end) {
      end.x[left] = end.x[n], end.value[left] = end.value[n], end.slope[left] = end.slope[n];
    };
    move(lanes_.low), move(lanes_.high);
    lanes_.next[left] = lanes_.next[n];
    rays_[left++] = ray;
  }
  count_ = left;
}

} // namespace bccsplat
