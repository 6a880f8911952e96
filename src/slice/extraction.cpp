// SPDX-License-Identifier: Apache-2.0
// Collects the 4D lattice points near a hyperplane in cells of slice space, and sums their Gaussians around
// points.
#include "slice/extraction.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"
#include "field/slice.h"
#include "kernel/kernel_time.h"
#include "slice/touched_samples.h"

namespace bccsplat {
namespace {

constexpr double gaussian = 2; // per T^2
constexpr double cutoff = 2;   // T: e^-8 of the peak
constexpr float grid_edge = 2; // T

// Returns the sum of exp(-2 |p - s|^2), |p - s| < 2, over all sites of D4*, by Poisson's formula: the mean,
// with what lies beyond the reach left out, and the 24 shortest dual vectors (+-1, +-1, 0, 0) / sqrt2 and so
// on.
double site_sum(const Vec4& p) {
  const double mean = std::pow(std::numbers::pi / gaussian, 2) / 2 * (1 - 9 * std::exp(-8));
  double pairs = 0, sum = 0;
  for (const double x : p) {
    const double c = std::cos(std::numbers::sqrt2 * std::numbers::pi * x);
    pairs += c * sum;
    sum += c;
  }
  return mean * (1 + 4 * std::exp(-std::numbers::pi * std::numbers::pi / gaussian) * pairs);
}

} // namespace

Extraction::Extraction(const SampleSource& source, int channel, const Hyperplane& h, const PlaneAxes& axes,
                       const Context& context)
    : axes_(axes), air_(source.air(channel)), base_(source.base(channel)) {
  const Lattice4& lattice = source.lattice();
  if (lattice.is_static() || !lattice.space.bcc || !source.coefficient_kernel().empty())
    fail(Code::unsupported, "slice: extracted points are of series of samples on D4* only");
  if (lattice.space.any_periodic())
    fail(Code::unsupported, "slice: extracted points: an axis of space is periodic; choose another method");
  const Vec3 unit = lattice.lattice_unit();
  for (size_t a = 0; a < 4; ++a) {
    scale_[a] = a < 3 ? 1 / unit[a] : kernel_time_per_frame(lattice);
    end_[a] = lattice.domain_end(a);
  }
  // Hyperplane and directions are brought to lattice units.
  const Hyperplane plane(h[0] / scale_[0], h[1] / scale_[1], h[2] / scale_[2], h[3] / scale_[3], h[4]);
  std::array<Vec4, 3> directions = axes.basis;
  for (size_t a = 0; a < 4; ++a) {
    origin_[a] = axes.origin[a] * scale_[a];
    for (Vec4& d : directions) d[a] *= scale_[a];
  }
  directions_ = plane_axes(origin_, directions).basis;

  TouchReach touch;
  for (size_t a = 0; a < 4; ++a) touch.samples[a] = cutoff / scale_[a];
  const TouchedSamples touched(source, h, touch);
  std::vector<Point> found;
  const double d = lattice.space.plane_distance();
  // The layers beyond the ends of a periodic series are those at its other end.
  const auto beyond =
      lattice.periodic ? static_cast<int32_t>(std::ceil(cutoff / lattice.layer_distance())) : 0;
  for (int32_t m = -beyond; m < lattice.layers() + beyond; ++m) {
    context.progress.advance(m + beyond, lattice.layers() + 2 * beyond);
    const BrickLayer layer = touched.read_layer(channel, lattice.mirror_layer(m), {}, context);
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      const Brick* brick = layer.brick(slot);
      if (!brick) continue;
      const Int3 b = layer.slot_position(slot);
      for (int s = 0; s < brick_sites; ++s) {
        if (!(brick->kept[s / brick_edge] >> s % brick_edge & 1)) continue;
        const auto at = [&](size_t a, int site) { // lattice units from source sample 0
          return d * (lattice.space.plane(layer.coset(), b[a] * brick_edge + site) - lattice.before[a]);
        };
        Vec4 p{at(0, s % brick_edge), at(1, s / brick_edge % brick_edge), at(2, s / brick_rows),
               kernel_time_of_layer(lattice, m)};
        const double distance = height(plane, p);
        if (!(std::fabs(distance) < cutoff)) continue;
        Point point;
        for (size_t a = 0; a < 4; ++a) p[a] -= origin_[a];
        for (size_t k = 0; k < 3; ++k) point.at[k] = static_cast<float>(dot4(p, directions_[k]));
        const float value = brick->value[s];
        range_ = {std::min(range_[0], value), std::max(range_[1], value)};
        point.d2 = static_cast<float>(distance * distance);
        point.weighted = static_cast<float>(std::exp(-gaussian * distance * distance)) * value;
        found.push_back(point);
      }
    }
  }

  if (!found.empty()) { // into cells
    std::array<float, 3> high = low_ = found[0].at;
    for (const Point& p : found)
      for (size_t k = 0; k < 3; ++k)
        low_[k] = std::min(low_[k], p.at[k]), high[k] = std::max(high[k], p.at[k]);
    for (size_t k = 0; k < 3; ++k) cells_[k] = 1 + static_cast<int>((high[k] - low_[k]) / grid_edge);
  }
  start_.resize(static_cast<size_t>(cells_[0]) * cells_[1] * cells_[2] + 1);
  for (const Point& p : found) ++start_[cell(p.at) + 1];
  for (size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  points_.resize(found.size());
  std::vector<uint64_t> next(start_.begin(), start_.end() - 1);
  for (const Point& p : found) points_[next[cell(p.at)]++] = p;
}

std::array<double, 2> Extraction::bounds() const {
  constexpr double largest_site_sum = 1.05; // what the closed form leaves out
  return {base_ + largest_site_sum * range_[0], base_ + largest_site_sum * range_[1]};
}

size_t Extraction::cell(const std::array<float, 3>& at) const {
  size_t index = 0;
  for (size_t k = 3; k-- > 0;) index = index * cells_[k] + static_cast<size_t>((at[k] - low_[k]) / grid_edge);
  return index;
}

float Extraction::value(const Vec4& p) const {
  Vec4 offset;
  for (size_t a = 0; a < 4; ++a) offset[a] = p[a] - origin_[a];
  std::array<float, 3> at;
  std::array<int, 3> first, last;
  for (size_t k = 0; k < 3; ++k) {
    at[k] = static_cast<float>(dot4(offset, directions_[k]));
    const auto r = static_cast<float>(cutoff);
    first[k] = std::max(0, static_cast<int>(std::floor((at[k] - r - low_[k]) / grid_edge)));
    last[k] = std::min(cells_[k] - 1, static_cast<int>(std::floor((at[k] + r - low_[k]) / grid_edge)));
  }
  double sum = 0;
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y) {
      if (first[0] > last[0]) continue;
      const auto row = (static_cast<size_t>(z) * cells_[1] + y) * cells_[0];
      const uint64_t end = start_[row + last[0] + 1];
      for (uint64_t i = start_[row + first[0]]; i < end; ++i) {
        const Point& point = points_[i];
        const float x = at[0] - point.at[0], v = at[1] - point.at[1], w = at[2] - point.at[2];
        const float r2 = x * x + v * v + w * w;
        if (r2 + point.d2 < static_cast<float>(cutoff * cutoff))
          sum += point.weighted * std::exp(-static_cast<float>(gaussian) * r2);
      }
    }
  return base_ + static_cast<float>(sum / site_sum(p));
}

uint64_t Extraction::sample(std::span<const Vec3> uvw, std::span<float> values,
                            const Context& context) const {
  constexpr uint64_t block = 1024;
  std::atomic<uint64_t> outside{0};
  context.tasks.parallel_for((uvw.size() + block - 1) / block, [&](uint64_t b) {
    context.progress.check();
    uint64_t out = 0;
    for (uint64_t n = b * block; n < std::min<uint64_t>(uvw.size(), (b + 1) * block); ++n) {
      Vec4 p = axes_.origin;
      bool inside = true;
      for (size_t i = 0; i < 4; ++i) {
        for (size_t k = 0; k < 3; ++k) p[i] += uvw[n][k] * axes_.basis[k][i];
        const double tolerance = domain_tolerance(end_[i]);
        inside = inside && p[i] >= -tolerance && p[i] <= end_[i] + tolerance;
        p[i] *= scale_[i];
      }
      values[n] = inside ? value(p) : std::numeric_limits<float>::quiet_NaN();
      out += !inside;
    }
    outside += out;
  });
  return outside;
}

void Extraction::sample(const Grid& grid, float* values, const Context& context) const {
  const uint64_t nx = grid.dims[0], ny = grid.dims[1];
  std::vector<Vec3> plane(nx * ny);
  for (uint64_t z = 0; z < static_cast<uint64_t>(grid.dims[2]); ++z) {
    for (uint64_t i = 0; i < plane.size(); ++i) {
      const Vec3 at{static_cast<double>(i % nx), static_cast<double>(i / nx), static_cast<double>(z)};
      for (size_t a = 0; a < 3; ++a) plane[i][a] = grid.origin[a] + grid.step[a] * at[a];
    }
    sample(plane, {values + z * plane.size(), plane.size()}, context);
  }
}

uint64_t Extraction::list(uint64_t capacity, float* uvw, float* weighted, Progress& progress) const {
  constexpr uint64_t points_per_check = 4096;
  // Directions in lattice units are combinations of the basis: (u, v, w) -> distances along them, and back.
  Affine3 along;
  for (size_t k = 0; k < 3; ++k)
    for (size_t j = 0; j < 3; ++j) {
      Vec4 d = axes_.basis[j];
      for (size_t a = 0; a < 4; ++a) d[a] *= scale_[a];
      along.linear[k][j] = dot4(d, directions_[k]);
    }
  const Affine3 back = along.inverse();
  for (uint64_t n = 0; n < std::min<uint64_t>(capacity, points_.size()); ++n) {
    if (n % points_per_check == 0) progress.check();
    const Point& p = points_[n];
    if (weighted) weighted[n] = p.weighted + (base_ - air_) * std::exp(-static_cast<float>(gaussian) * p.d2);
    if (!uvw) continue;
    const Vec3 at = back.vector({p.at[0], p.at[1], p.at[2]});
    for (size_t k = 0; k < 3; ++k) uvw[3 * n + k] = static_cast<float>(at[k]);
  }
  return points_.size();
}

} // namespace bccsplat
