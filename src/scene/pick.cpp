// SPDX-License-Identifier: Apache-2.0
// Evaluates the field along a ray, eight times as finely as its samples, and more finely where it looks for a
// place.
#include "scene/pick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "draw/shot.h"
#include "shade/absorption.h"
#include "view/camera.h"

namespace bccsplat {
namespace {

constexpr double samples_per_unit = 8; // of slice space
constexpr double most_samples = 1 << 20;
// Places are found by so many rounds, each as many times as fine as the one before.
constexpr int rounds = 4, finer = 8;

// The part of a ray inside a slice, with values at distances along it.
class RayValues {
 public:
  RayValues(const OpenSlice& slice, const PickRay& ray, const Context& context)
      : slice_(slice), ray_(ray), context_(context), to_slice_(slice.slice.slice_to_world.inverse()),
        to_lattice_(slice.slice.lattice_to_slice.inverse().after(to_slice_)), box_(drawn_box(slice.slice)) {
    begin_ = ray.begin;
    end_ = ray.end.value_or(std::numeric_limits<double>::infinity());
    const Vec3 origin = to_lattice_.point(ray.origin), along = to_lattice_.vector(ray.direction);
    for (size_t a = 0; a < 3; ++a)
      keep(along[a], origin[a] - box_.begin[a]), keep(-along[a], box_.end[a] - origin[a]);
    for (const HalfSpace& plane : slice.slice.clip)
      keep(dot(plane.normal, along), dot(plane.normal, origin) + plane.offset);
    if (any())
      count_ = static_cast<size_t>(std::clamp(
          std::ceil((end_ - begin_) * samples_along(ray.direction) * samples_per_unit), 1.0, most_samples));
  }

  // Samples in a unit of a direction; along uneven axes as many as lattice planes, which are as close as its
  // closest samples.
  [[nodiscard]] double samples_along(const Vec3& direction) const {
    return std::max(length(to_slice_.vector(direction)), length(to_lattice_.vector(direction)));
  }
  [[nodiscard]] bool any() const { return begin_ <= end_ && std::isfinite(begin_) && std::isfinite(end_); }
  [[nodiscard]] size_t steps() const { return count_; }
  [[nodiscard]] double step() const { return (end_ - begin_) / static_cast<double>(count_); }
  [[nodiscard]] double at(size_t n) const { return begin_ + step() * static_cast<double>(n); }

  // Returns the values at `count` + 1 distances from one to another; NaN in holes.
  [[nodiscard]] std::vector<float> between(double from, double to, size_t count) const {
    std::vector<Vec3> points(count + 1);
    for (size_t n = 0; n <= count; ++n)
      points[n] = place(from + (to - from) * static_cast<double>(n) / static_cast<double>(count));
    std::vector<float> values(count + 1);
    (void)slice_.evaluate(points, values, {}, context_);
    return values;
  }
  [[nodiscard]] std::vector<float> all() const { return between(begin_, end_, count_); }

  [[nodiscard]] PickHit hit(double distance) const {
    PickHit out;
    out.distance = distance, out.world = ray_.origin + distance * ray_.direction, out.place = place(distance);
    const std::array<Vec3, 1> point{out.place};
    std::array<float, 1> value{};
    std::array<std::array<float, 3>, 1> slope{};
    (void)slice_.evaluate(point, value, slope, context_);
    out.value = value[0];
    out.gradient = to_slice_.transposed({slope[0][0], slope[0][1], slope[0][2]});
    return out;
  }

 private:
  // Keeps the part where slope * distance + offset is not negative.
  void keep(double slope, double offset) {
    if (slope > 0)
      begin_ = std::max(begin_, -offset / slope);
    else if (slope < 0)
      end_ = std::min(end_, -offset / slope);
    else if (offset < 0)
      end_ = -std::numeric_limits<double>::infinity();
  }
  // A point of slice space; rounding leaves none outside the domain, and where that is a plane without
  // thickness the point is in it.
  [[nodiscard]] Vec3 place(double distance) const {
    Vec3 p = to_lattice_.point(ray_.origin + distance * ray_.direction);
    for (size_t a = 0; a < 3; ++a)
      p[a] = std::clamp(p[a], slice_.slice.domain_begin[a], slice_.slice.domain_end[a]);
    return slice_.slice.lattice_to_slice.point(p);
  }

  const OpenSlice& slice_;
  const PickRay& ray_;
  const Context& context_;
  Affine3 to_slice_, to_lattice_; // from the world
  DrawnBox box_;                  // in units of the lattice, as the slice's clips are
  double begin_ = 0, end_ = 0;
  size_t count_ = 0;
};

// Returns the first pair of neighbours that the threshold lies between; none: the count.
size_t first_passed(const std::vector<float>& values, double threshold) {
  for (size_t n = 0; n + 1 < values.size(); ++n) {
    const double a = values[n] - threshold, b = values[n + 1] - threshold;
    if ((a <= 0 && b >= 0) || (a >= 0 && b <= 0)) return n;
  }
  return values.size();
}

std::optional<double> find_value(const RayValues& ray, double threshold) {
  const size_t n = first_passed(ray.all(), threshold);
  if (n > ray.steps()) return std::nullopt;
  double from = ray.at(n), to = ray.at(n + 1);
  for (int round = 0; round < rounds; ++round) {
    const std::vector<float> values = ray.between(from, to, finer);
    const size_t part = std::min(first_passed(values, threshold), size_t{finer - 1});
    const double width = (to - from) / finer;
    from += width * static_cast<double>(part), to = from + width;
  }
  return to; // of labels the one that is met, not the one before
}

// Returns the number of the largest value; none where all are NaN.
std::optional<size_t> largest(const std::vector<float>& values) {
  std::optional<size_t> most;
  for (size_t n = 0; n < values.size(); ++n)
    if (!std::isnan(values[n]) && (!most || values[n] > values[*most])) most = n;
  return most;
}

std::optional<double> find_maximum(const RayValues& ray) {
  const std::optional<size_t> most = largest(ray.all());
  if (!most) return std::nullopt;
  const double begin = ray.at(0), end = ray.at(ray.steps());
  double at = ray.at(*most), around = ray.step();
  for (int round = 0; round < rounds; ++round) {
    const double from = std::max(begin, at - around), to = std::min(end, at + around);
    const std::vector<float> values = ray.between(from, to, size_t{2} * finer);
    if (const auto n = largest(values)) at = from + (to - from) * static_cast<double>(*n) / (2.0 * finer);
    around /= finer;
  }
  return at;
}

std::optional<double> find_opacity(const RayValues& ray, const TransferFunction& function, double threshold,
                                   double unit) {
  const double wanted = -std::log1p(-threshold), step = ray.step();
  const std::vector<float> values = ray.all();
  const auto per_length = [&](float value) {
    return std::isnan(value) ? 0 : extinction(function.opacity(value), unit);
  };
  double depth = 0; // by the trapezium rule
  for (size_t n = 0; n < ray.steps(); ++n) {
    const double more = (per_length(values[n]) + per_length(values[n + 1])) / 2 * step;
    if (more > 0 && depth + more >= wanted) return ray.at(n) + step * (wanted - depth) / more;
    depth += more;
  }
  return std::nullopt;
}

} // namespace

std::optional<PickHit> pick(const OpenSlice& slice, const PickRay& ray, const Context& context) {
  if (slice.slice.empty()) return std::nullopt;
  const RayValues values(slice, ray, context);
  if (!values.any()) return std::nullopt;
  std::optional<double> found;
  if (ray.kind == PickKind::value) found = find_value(values, ray.threshold);
  if (ray.kind == PickKind::maximum) found = find_maximum(values);
  if (ray.kind == PickKind::opacity) {
    const double own = ray.function->unit_distance;
    found = find_opacity(values, *ray.function, ray.threshold, own > 0 ? own : mean_voxel(slice.slice));
  }
  if (!found) return std::nullopt;
  return values.hit(*found);
}

} // namespace bccsplat
