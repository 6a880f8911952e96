// SPDX-License-Identifier: Apache-2.0
// All rays take a step at a time together, because sums of footprints are cheapest side by side. A ray knows
// on which side of the target it begins; it looks where its neighbours were hit, goes back from there where
// it has passed the surface already, and on while it comes nearer to one: beside a silhouette the neighbours'
// hits lie well before the place where the ray passes closest.
#include "shade/edge_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bccsplat {
namespace {

// Samples along a ray are 1 T apart, where sheets allow: their slopes tell of what lies between.
double sheets_apart(const SheetView& view) { return std::clamp(1 / view.step, 1.0, 2.0); }
// A ray goes on past its neighbours' hits while the tangent meets the target within so many samples.
constexpr double approach = 8;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

struct Station {
  double k = 0, value = 0, slope = nan_value; // per sheet
};

// One ray's walk.
class Walk {
 public:
  enum class Event : uint8_t { none, crossing, graze, end };

  Walk(const EdgeRay& ray, double target, double step)
      : ray_(ray), target_(target), step_(step), k_(ray.enter) {}

  [[nodiscard]] double k() const { return k_; }
  [[nodiscard]] Crossing interval(uint32_t number) const {
    return {ray_.i, ray_.j, low_.k, high_.k, low_.value, high_.value, low_.slope, high_.slope, number};
  }

  // Takes the sample at k().
  Event take(double value, double slope) {
    const Station here{k_, value, slope};
    if (!begun_) {
      begun_ = true, below_ = value < target_;
      last_ = here;
      return go_on();
    }
    if (back_) {
      if ((value < target_) != below_) {
        high_ = here;
        return go_back();
      }
      low_ = here;
      return Event::crossing;
    }
    const bool beside = k_ - last_.k < 1.5 * step_;
    if ((value < target_) != below_) {
      high_ = here;
      low_ = last_;
      if (beside) return Event::crossing;
      back_ = true;
      return go_back();
    }
    const Station before = last_;
    last_ = here;
    if (beside && may_graze(before, here)) {
      low_ = before, high_ = here;
      return Event::graze;
    }
    return go_on();
  }

  // The graze was none.
  Event pass_by() { return go_on(); }

  // Goes on behind the surface that ends at `high`: data are missing there, or it is seen through.
  Event pass_through(double high, double value) {
    below_ = !below_, back_ = false;
    last_ = {high, value, nan_value};
    return go_on();
  }

 private:
  // Distance from the target and its slope, on the side that the ray is on.
  [[nodiscard]] double gap(const Station& s) const { return below_ ? target_ - s.value : s.value - target_; }
  [[nodiscard]] double closing(const Station& s) const { return below_ ? s.slope : -s.slope; }

  // Returns whether the tangents at both ends meet beyond the target.
  [[nodiscard]] bool may_graze(const Station& a, const Station& b) const {
    const double u = closing(a), v = -closing(b);
    if (!(u > 0 && v > 0)) return false;
    return gap(a) - u * (gap(a) - gap(b) + v * (b.k - a.k)) / (u + v) <= 0;
  }

  Event go_on() {
    if (!(last_.k < ray_.leave)) return Event::end;
    while (run_ < ray_.nearby.size() && ray_.nearby[run_].last + step_ <= last_.k) ++run_;
    const double near = closing(last_) > 0 ? gap(last_) / closing(last_) : infinity;
    const bool inside = run_ < ray_.nearby.size() && ray_.nearby[run_].first - step_ <= last_.k;
    if (inside || (last_.k > ray_.enter && near < approach * step_)) {
      k_ = last_.k + step_;
    } else {
      if (run_ == ray_.nearby.size()) return Event::end;
      k_ = std::max(ray_.nearby[run_].first - step_, last_.k + step_);
    }
    k_ = std::min(k_, ray_.leave);
    return Event::none;
  }

  // Towards the last sample before, which is on the side where the ray begins.
  Event go_back() {
    k_ = high_.k - step_;
    if (k_ > last_.k) return Event::none;
    low_ = last_;
    return Event::crossing;
  }

  EdgeRay ray_;
  double target_, step_, k_;
  bool begun_ = false, below_ = false, back_ = false;
  size_t run_ = 0;
  Station last_;       // the furthest known before the surface
  Station low_, high_; // of the event
};

} // namespace

std::vector<EdgeHit> trace_edge_rays(const SurfaceField& field, const SheetView& view, double target,
                                     double tolerance, std::span<const EdgeRay> rays, bool all) {
  std::vector<EdgeHit> hits;
  std::vector<Walk> walks;
  std::vector<uint32_t> active;
  for (const EdgeRay& ray : rays) {
    if (ray.enter < ray.leave && !ray.nearby.empty()) active.push_back(static_cast<uint32_t>(walks.size()));
    walks.emplace_back(ray, target, sheets_apart(view));
  }
  std::vector<Vec3> p, gradient;
  std::vector<float> value;
  std::vector<Crossing> crossings, grazes;
  std::vector<uint32_t> next;
  while (!active.empty()) {
    p.clear(), crossings.clear(), grazes.clear(), next.clear();
    for (const uint32_t n : active) p.push_back(view.sample(rays[n].i, rays[n].j, walks[n].k()));
    value.resize(p.size()), gradient.resize(p.size());
    field_at(field, p, value, gradient);
    for (size_t m = 0; m < active.size(); ++m) {
      const uint32_t n = active[m];
      const Walk::Event event = walks[n].take(value[m], dot(gradient[m], view.ray(rays[n].i, rays[n].j)));
      if (event == Walk::Event::none) next.push_back(n);
      if (event == Walk::Event::crossing) crossings.push_back(walks[n].interval(n));
      if (event == Walk::Event::graze) grazes.push_back(walks[n].interval(n));
    }
    std::vector<uint8_t> grazed(grazes.empty() ? 0 : rays.size());
    for (const Crossing& c : find_grazes(field, view, target, grazes)) {
      grazed[c.number] = 1;
      crossings.push_back(c);
    }
    for (const Crossing& c : grazes)
      if (!grazed[c.number] && walks[c.number].pass_by() == Walk::Event::none) next.push_back(c.number);
    const auto found = refine_crossings(field, view, target, crossings, tolerance);
    for (size_t m = 0; m < found.size(); ++m) {
      const Crossing& c = crossings[m];
      const bool hole = field.slice.has_holes && field.slice.is_hole(found[m].position);
      if (!hole) hits.push_back({c.number, found[m]});
      if ((hole || all) && walks[c.number].pass_through(c.high, c.value_high) == Walk::Event::none)
        next.push_back(c.number);
    }
    active.swap(next);
  }
  return hits;
}

} // namespace bccsplat
