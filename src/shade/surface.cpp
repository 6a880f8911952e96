// SPDX-License-Identifier: Apache-2.0
// Finds where rays pass an iso value, by the field itself: Newton's method inside the bracket that two sheets
// give, for many rays at once, because sums of footprints are cheapest side by side. The notes are
// tests/bench/notes/isosurfaces.md.
#include "shade/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace bccsplat {

namespace {

FootprintPlan footprints_of(const Slice& slice) {
  const std::array<FieldLayer, 2> layers{FieldLayer{&slice.coset[0]}, FieldLayer{&slice.coset[1]}};
  return FootprintPlan({std::span(layers).first(slice.lattice.cosets()), &slice.kernel});
}

} // namespace

SurfaceField::SurfaceField(const Slice& of, std::shared_ptr<const LatticeSums> of_kernel)
    : slice(of), sums(std::move(of_kernel)), footprints(footprints_of(of)) {}

Vec3 SurfaceField::lit_gradient(const Vec3& p, double value, const Vec3& gradient) const {
  return sums ? sums->without_ripple(p, value, gradient) : gradient;
}

void SurfaceField::make_lit(std::span<const Vec3> points, std::span<const double> values,
                            std::span<Vec3> gradients) const {
  if (sums) sums->take_ripple_off(points, values, gradients);
}

void field_at(const SurfaceField& field, std::span<const Vec3> points, std::span<float> values,
              std::span<Vec3> gradients) {
  if (field.slice.scattered) return field.slice.scattered->at(points, values, gradients);
  constexpr size_t block = 512;
  std::array<Vec4, block> p;
  std::array<std::array<float, 4>, block> slope;
  for (size_t from = 0; from < points.size(); from += block) {
    const size_t count = std::min(block, points.size() - from);
    for (size_t n = 0; n < count; ++n)
      p[n] = {points[from + n][0], points[from + n][1], points[from + n][2], 0};
    sum_footprints(field.footprints, std::span(p).first(count), values.data() + from, slope.data());
    for (size_t n = 0; n < count; ++n)
      for (size_t a = 0; a < 3; ++a) gradients[from + n][a] = slope[n][a];
  }
  if (!field.slice.corrections) return;
  const Affine3& to_slice = field.slice.lattice_to_slice;
  for (size_t n = 0; n < points.size(); ++n) {
    Vec3 per_uvw;
    values[n] += field.slice.corrections->at(to_slice.point(points[n]), &per_uvw);
    gradients[n] = gradients[n] + to_slice.transposed(per_uvw);
  }
}

namespace {

// Returns where the cubic through a crossing's values and slopes passes the target, else the straight line.
double first_guess(const Crossing& c, double target) {
  const double d0 = c.value_low - target, d1 = c.value_high - target;
  double x = d0 / (d0 - d1); // from low to high
  if (!std::isnan(c.slope_low)) {
    const double s0 = c.slope_low * (c.high - c.low), s1 = c.slope_high * (c.high - c.low);
    const double square = 3 * (d1 - d0) - 2 * s0 - s1, cube = 2 * (d0 - d1) + s0 + s1;
    for (int step = 0; step < 3; ++step) {
      const double f = d0 + x * (s0 + x * (square + x * cube));
      const double next = x - f / (s0 + x * (2 * square + x * 3 * cube));
      if (!(next > 0 && next < 1)) break;
      x = next;
    }
  }
  return c.low + (c.high - c.low) * x;
}

} // namespace

std::vector<SurfacePoint> refine_crossings(const SurfaceField& field, const SheetView& view, double target,
                                           std::span<const Crossing> crossings, double tolerance) {
  std::vector<SurfacePoint> hits(crossings.size());
  std::vector<Crossing> bracket(crossings.begin(), crossings.end());
  std::vector<Vec3> p(hits.size()), gradient(hits.size());
  std::vector<float> value(hits.size());
  std::vector<Vec3> last_p(hits.size()), last_gradient(hits.size()); // of each, before its last step
  std::vector<double> last_value(hits.size());
  std::vector<uint32_t> open(hits.size()); // crossings whose root is not near enough yet
  std::iota(open.begin(), open.end(), 0u);
  for (size_t n = 0; n < hits.size(); ++n) hits[n].k = first_guess(crossings[n], target);
  const Affine3 to_lattice = view.lattice_to_world.inverse();
  // Newton's method along the ray, kept inside the bracket.
  constexpr int steps = 3;
  for (int step = 0; step < steps && !open.empty(); ++step) {
    for (size_t m = 0; m < open.size(); ++m)
      p[m] = view.sample(bracket[open[m]].i, bracket[open[m]].j, hits[open[m]].k);
    field_at(field, std::span(p).first(open.size()), value, gradient);
    size_t left = 0;
    for (size_t m = 0; m < open.size(); ++m) {
      const uint32_t n = open[m];
      Crossing& c = bracket[n];
      SurfacePoint& hit = hits[n];
      const double f = value[m];
      (f < target) == (c.value_low < target) ? c.low = hit.k : c.high = hit.k;
      const double slope = dot(gradient[m], view.ray(c.i, c.j));
      const double next = hit.k + (target - f) / slope;
      const bool near = std::fabs(next - hit.k) <= tolerance;
      const bool inside = next >= c.low && next <= c.high;
      hit.k = near || inside ? std::clamp(next, c.low, c.high) : 0.5 * (c.low + c.high);
      if (near || step + 1 == steps) {
        hit.position = view.sample(c.i, c.j, hit.k);
        last_p[n] = p[m], last_value[n] = f, last_gradient[n] = gradient[m];
      } else {
        open[left++] = n;
      }
    }
    open.resize(left);
  }
  field.make_lit(last_p, last_value, last_gradient);
  for (size_t n = 0; n < hits.size(); ++n) hits[n].gradient = to_lattice.transposed(last_gradient[n]);
  return hits;
}

std::vector<Crossing> find_grazes(const SurfaceField& field, const SheetView& view, double target,
                                  std::span<const Crossing> intervals) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  struct Search {
    Crossing interval;
    double low, high, slope_low, slope_high, k; // the turning point lies in [low, high]
  };
  std::vector<Search> open;
  for (const Crossing& c : intervals) open.push_back({c, c.low, c.high, 0, 0, 0.5 * (c.low + c.high)});
  std::vector<Crossing> found;
  std::vector<Vec3> p, gradient;
  std::vector<float> value;
  constexpr int steps = 4;
  for (int step = 0; step < steps && !open.empty(); ++step) {
    p.clear();
    for (const Search& s : open) p.push_back(view.sample(s.interval.i, s.interval.j, s.k));
    gradient.resize(p.size()), value.resize(p.size());
    field_at(field, p, value, gradient);
    std::vector<Search> left;
    for (size_t n = 0; n < open.size(); ++n) {
      Search& s = open[n];
      const double f = value[n];
      const bool below = s.interval.value_low < target;
      if ((f < target) != below) {
        found.push_back({s.interval.i, s.interval.j, s.interval.low, s.k, s.interval.value_low, f, nan, nan,
                         s.interval.number});
        continue;
      }
      // Towards the target the slope is positive, seen from below.
      const double slope = (below ? 1 : -1) * dot(gradient[n], view.ray(s.interval.i, s.interval.j));
      (slope > 0 ? s.low : s.high) = s.k;
      (slope > 0 ? s.slope_low : s.slope_high) = slope;
      const bool both = s.slope_low > 0 && s.slope_high < 0;
      const double part = both ? s.slope_low / (s.slope_low - s.slope_high) : 0.5;
      s.k = s.low + part * (s.high - s.low);
      left.push_back(s);
    }
    open = std::move(left);
  }
  return found;
}

TimeField::TimeField(const Slice& slice) {
  if (slice.is_time_slice()) {
    offset = slice.origin[3];
    return;
  }
  const Vec3 per_uvw{slice.basis[0][3], slice.basis[1][3], slice.basis[2][3]};
  gradient = slice.lattice_to_slice.transposed(per_uvw);
  offset = slice.origin[3] + dot(per_uvw, slice.lattice_to_slice.offset);
}

} // namespace bccsplat
