// SPDX-License-Identifier: Apache-2.0
// Looks up values where points are: those that lie together read what is around them, labels are those of the
// nearest samples.
#include "volume/values_at.h"

#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "base/text.h"
#include "volume/label_samples.h"
#include "volume/labels.h"

namespace bccsplat {
namespace {

// Index units of a point of the world; the last one is NaN at times outside the series.
Vec4 to_index(const OpenVolume& volume, const Affine3& to_space, const Vec4& world) {
  const Vec3 p = volume.axes()->index_of(to_space.point({world[0], world[1], world[2]}));
  const TimeAxis& times = volume.times();
  const bool is_static = volume.info().lattice.is_static();
  double t = std::numeric_limits<double>::quiet_NaN();
  if (is_static)
    t = 0;
  else if (times.holds(world[3]))
    t = times.index_of(world[3]);
  return {p[0], p[1], p[2], t};
}

// What a probe's own bricks are told apart by, index units; more points than that are no probes.
constexpr double cluster_edge = 32;
constexpr size_t most_probes = 1 << 17;

using Cluster = std::vector<size_t>; // numbers of points

// Returns the points by where they are: those of a cube of space, at any time, together. One cluster of all
// where that asks for no more bricks.
std::vector<Cluster> clusters_of(const OpenVolume& volume, std::span<const Vec4> points) {
  std::map<std::array<double, 3>, Cluster> cubes;
  for (size_t n = 0; n < points.size(); ++n) {
    const auto cube = [&](size_t a) {
      return std::floor(std::isnan(points[n][a]) ? 0 : points[n][a] / cluster_edge);
    };
    cubes[{cube(0), cube(1), cube(2)}].push_back(n);
  }
  std::vector<Cluster> clusters;
  double share = 0;
  for (auto& [cube, cluster] : cubes) {
    std::vector<Vec4> own;
    for (const size_t n : cluster) own.push_back(points[n]);
    share += volume.share_around(own);
    clusters.push_back(std::move(cluster));
  }
  if (clusters.size() > 1 && share < volume.share_around(points)) return clusters;
  Cluster all(points.size());
  std::iota(all.begin(), all.end(), size_t{0});
  return {all};
}

// Does what evaluate4() does, in one go; labels: the points are samples of labels, which the file has.
EvaluateMisses evaluate_near(const OpenVolume& volume, uint32_t channel, bool labels,
                             std::span<const Vec4> points, std::span<float> values,
                             std::span<std::array<float, 4>> gradients, const Context& context) {
  const EvaluateMisses misses =
      evaluate4(*volume.coefficients_at(channel, points), points, values, gradients, context);
  if (labels) read_labels(volume, channel, points, values, context);
  return misses;
}

// The same, reading what is around each cluster of probes.
EvaluateMisses evaluate_clusters(const OpenVolume& volume, uint32_t channel, bool labels,
                                 std::span<const Vec4> points, std::span<float> values,
                                 std::span<std::array<float, 4>> gradients, const Context& context) {
  std::vector<Cluster> clusters;
  if (points.size() <= most_probes) clusters = clusters_of(volume, points);
  if (clusters.size() < 2) return evaluate_near(volume, channel, labels, points, values, gradients, context);
  EvaluateMisses misses;
  for (const Cluster& cluster : clusters) {
    std::vector<Vec4> own;
    for (const size_t n : cluster) own.push_back(points[n]);
    std::vector<float> found(own.size());
    std::vector<std::array<float, 4>> slopes(gradients.empty() ? 0 : own.size());
    const EvaluateMisses more = evaluate_near(volume, channel, labels, own, found, slopes, context);
    misses.outside += more.outside, misses.holes += more.holes;
    for (size_t i = 0; i < cluster.size(); ++i) {
      values[cluster[i]] = found[i];
      if (!gradients.empty()) gradients[cluster[i]] = slopes[i];
    }
  }
  return misses;
}

// Returns the labels at the samples nearest to the points, and what is missing there; labels have no slope.
EvaluateMisses labels_at(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> points,
                         std::span<float> values, std::span<std::array<float, 4>> gradients,
                         const Context& context) {
  const Reservation memory(context.memory, points.size() * sizeof(Vec4), "the samples nearest to points");
  std::vector<Vec4> samples(points.begin(), points.end());
  snap_to_samples(volume, samples);
  const EvaluateMisses misses = evaluate_clusters(volume, channel, true, samples, values, gradients, context);
  for (std::array<float, 4>& g : gradients)
    if (!std::isnan(g[0])) g = {};
  return misses;
}

} // namespace

EvaluateMisses values_at(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> points,
                         std::span<float> values, std::span<std::array<float, 4>> gradients,
                         const Context& context) {
  if (is_labels(volume, channel)) return labels_at(volume, channel, points, values, gradients, context);
  return evaluate_clusters(volume, channel, false, points, values, gradients, context);
}

EvaluateMisses values_at_world(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> points,
                               std::span<float> values, std::span<std::array<float, 4>> gradients,
                               const Context& context) {
  const Reservation memory(context.memory, points.size() * sizeof(Vec4), "points of the world");
  const Affine3 to_space = volume.affine().inverse();
  std::vector<Vec4> at(points.size());
  for (size_t n = 0; n < at.size(); ++n) at[n] = to_index(volume, to_space, points[n]);
  const EvaluateMisses misses = values_at(volume, channel, at, values, gradients, context);
  for (size_t n = 0; n < gradients.size(); ++n) {
    std::array<float, 4>& g = gradients[n];
    const Vec3 stretch = volume.axes()->slopes_at({at[n][0], at[n][1], at[n][2]});
    const Vec3 space = to_space.transposed({g[0] / stretch[0], g[1] / stretch[1], g[2] / stretch[2]});
    const double per_time = std::isnan(at[n][3]) ? 1 : 1 / volume.times().slope_at(at[n][3]);
    g = {static_cast<float>(space[0]), static_cast<float>(space[1]), static_cast<float>(space[2]),
         static_cast<float>(g[3] * per_time)};
  }
  return misses;
}

std::string first_outside(const OpenVolume& volume, std::span<const Vec4> points, bool world) {
  const Lattice4& lattice = volume.lattice(0);
  const Affine3 to_space = world ? volume.affine().inverse() : Affine3{};
  for (size_t n = 0; n < points.size(); ++n) {
    const Vec4 p = world ? to_index(volume, to_space, points[n]) : points[n];
    for (size_t a = 0; a < (lattice.is_static() ? 3u : 4u); ++a) {
      const double end = lattice.domain_end(a), slack = domain_tolerance(end);
      if (p[a] >= -slack && p[a] <= end + slack) continue;
      if (world && a == 3)
        return concat("point ", n, " has the time ", points[n][3], ", outside ", volume.times().first(),
                      " to ", volume.times().last());
      return concat("point ", n, " has the index ", p[a], " along ", "xyzt"[a], ", outside 0 to ", end);
    }
  }
  return {};
}

} // namespace bccsplat
