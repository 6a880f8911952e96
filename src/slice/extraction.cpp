// SPDX-License-Identifier: Apache-2.0
// Sums the Gaussians of extracted points: around single points, from the cells beside them, and onto the
// samples of a sheet, row by row, where the weights of neighbouring samples differ by a factor that itself
// changes by a constant one. How the points are found is in extraction_points.cpp.
#include "slice/extraction.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/grid.h"
#include "field/slice.h"
#include "slice/extraction_gaussian.h"

namespace bccsplat {
namespace {

constexpr double pi = std::numbers::pi;

// Returns the sum of exp(-2 |p - s|^2), |p - s| < 2, over all sites of D4* or CC, by Poisson's formula: the
// mean, with what lies beyond the reach left out, and the shortest dual vectors, of length 1 on both: the 24
// (+-1, +-1, 0, 0) / sqrt2 and so on of D4*, the 8 unit vectors of CC. slope: what it changes by along each
// axis.
double site_sum(const Vec4& p, bool bcc, Vec4& slope) {
  const double mean = std::pow(pi / paper_gaussian, 2) / (bcc ? 2 : 1) *
                      (1 - (1 + paper_gaussian * paper_reach * paper_reach) *
                               std::exp(-paper_gaussian * paper_reach * paper_reach));
  const double height = 2 * mean * std::exp(-pi * pi / paper_gaussian);
  const double turn = bcc ? std::numbers::sqrt2 * pi : 2 * pi;
  Vec4 cosine;
  double all = 0, pairs = 0;
  for (size_t a = 0; a < 4; ++a) {
    cosine[a] = std::cos(turn * p[a]);
    pairs += cosine[a] * all, all += cosine[a];
  }
  for (size_t a = 0; a < 4; ++a)
    slope[a] = -height * turn * std::sin(turn * p[a]) * (bcc ? 2 * (all - cosine[a]) : 1);
  return mean + height * (bcc ? 2 * pairs : all);
}

} // namespace

std::array<double, 2> Extraction::bounds() const {
  constexpr double largest_site_sum = 1.05; // what the closed form leaves out
  return {base_ + largest_site_sum * range_[0], base_ + largest_site_sum * range_[1]};
}

std::array<int, 2> Extraction::cells_around(size_t axis, float low, float high) const {
  const auto cell_of = [&](float x) {
    return static_cast<int>(
        std::clamp(std::floor((x - low_[axis]) / extraction_cell), -1.0f, static_cast<float>(cells_[axis])));
  };
  return {std::max(0, cell_of(low)), std::min(cells_[axis] - 1, cell_of(high))};
}

double Extraction::full_sum(const Vec3& at, Vec3* gradient) const {
  Vec4 p = origin_, slope;
  for (size_t k = 0; k < 3; ++k)
    for (size_t a = 0; a < 4; ++a) p[a] += at[k] * directions_[k][a];
  const double sum = site_sum(p, bcc_, slope);
  if (gradient)
    for (size_t k = 0; k < 3; ++k) (*gradient)[k] = dot4(slope, directions_[k]);
  return sum;
}

double Extraction::value(const Vec3& at, Vec3* gradient) const {
  constexpr auto reach = static_cast<float>(paper_reach);
  std::array<float, 3> p;
  std::array<std::array<int, 2>, 3> range;
  for (size_t k = 0; k < 3; ++k) {
    p[k] = static_cast<float>(at[k]);
    range[k] = cells_around(k, p[k] - reach, p[k] + reach);
  }
  if (range[0][0] > range[0][1]) range[1][1] = range[1][0] - 1;
  double sum = 0;
  Vec3 slope{};
  for (int z = range[2][0]; z <= range[2][1]; ++z)
    for (int y = range[1][0]; y <= range[1][1]; ++y) {
      const auto row = (static_cast<size_t>(z) * cells_[1] + y) * cells_[0];
      const uint64_t end = start_[row + range[0][1] + 1];
      for (uint64_t i = start_[row + range[0][0]]; i < end; ++i) {
        const Point& point = points_[i];
        const float x = p[0] - point.at[0], v = p[1] - point.at[1], w = p[2] - point.at[2];
        const float r2 = x * x + v * v + w * w;
        if (!(r2 + point.d2 < reach * reach)) continue;
        const double part = point.weighted * std::exp(-static_cast<float>(paper_gaussian) * r2);
        sum += part;
        slope = slope + part * Vec3{x, v, w};
      }
    }
  Vec3 full_slope;
  const double full = full_sum(at, gradient ? &full_slope : nullptr);
  if (gradient) *gradient = (1 / full) * (-2 * paper_gaussian * slope - (sum / full) * full_slope);
  return sum / full;
}

void Extraction::at(std::span<const Vec3> points, std::span<float> values, std::span<Vec3> gradients) const {
  for (size_t n = 0; n < points.size(); ++n) {
    Vec3 slope;
    values[n] = static_cast<float>(value(of_lattice_.point(points[n]), &slope));
    gradients[n] = of_lattice_.transposed(slope);
  }
}

void Extraction::each_point(const std::function<void(const Vec3&, float, float)>& body) const {
  const Affine3 back = of_lattice_.inverse();
  for (const Point& p : points_) {
    const float share = std::exp(-static_cast<float>(paper_gaussian) * p.d2);
    body(back.point({p.at[0], p.at[1], p.at[2]}), p.weighted / share, share);
  }
}

// A sheet as the points see it, and what adds one of them to its samples.
struct Extraction::Splats {
  const ScatterSheet& sheet;
  Vec3 origin, per_i, per_j, normal; // along the directions
  double ii, ij, jj, det;            // products of the steps
  double step;                       // factor of the factors
  bool any = false;

  Splats(const ScatterSheet& s, const Affine3& to_directions)
      : sheet(s), origin(to_directions.point(s.origin)), per_i(to_directions.vector(s.per_i)),
        per_j(to_directions.vector(s.per_j)), normal(normalized(cross(per_i, per_j))), ii(dot(per_i, per_i)),
        ij(dot(per_i, per_j)), jj(dot(per_j, per_j)), det(ii * jj - ij * ij),
        step(std::exp(-2 * paper_gaussian * ii)) {}

  [[nodiscard]] Vec3 at(int i, int j) const { return origin + i * per_i + j * per_j; }

  // Adds a point on one row of samples: `below` of its exponent are known.
  void add_row(int j, double middle, double half, double below, double weight) {
    const int from = static_cast<int>(std::ceil(middle - half)),
              to = std::min(static_cast<int>(std::floor(middle + half)), sheet.x + sheet.width - 1);
    if (to < sheet.x || from > to) return;
    const double x = from - middle;
    double w = weight * std::exp(-paper_gaussian * (below + ii * x * x));
    double factor = std::exp(-paper_gaussian * ii * (2 * x + 1));
    float* const row = sheet.values + plane_offset(-sheet.x, j - sheet.y, sheet.pitch);
    for (int i = from; i <= to; ++i) {
      if (i >= sheet.x) row[i] += static_cast<float>(w);
      w *= factor, factor *= step;
    }
    any = true;
  }

  void add(const Point& point) {
    const Vec3 d = origin - Vec3{point.at[0], point.at[1], point.at[2]};
    const double h = dot(normal, d), left = paper_reach * paper_reach - point.d2 - h * h;
    if (!(left > 0)) return;
    const double bi = dot(per_i, d), bj = dot(per_j, d);
    const double ci = (ij * bj - jj * bi) / det, cj = (ij * bi - ii * bj) / det; // nearest sample
    const double half_rows = std::sqrt(left * ii / det);
    constexpr double far = 1e8;
    if (!(std::fabs(ci) < far && std::fabs(cj) < far)) return;
    const int j0 = std::max(sheet.y, static_cast<int>(std::ceil(cj - half_rows)));
    const int j1 = std::min(sheet.y + sheet.height - 1, static_cast<int>(std::floor(cj + half_rows)));
    for (int j = j0; j <= j1; ++j) {
      const double row = j - cj, off = det / ii * row * row;
      if (left > off)
        add_row(j, ci - ij / ii * row, std::sqrt((left - off) / ii), h * h + off, point.weighted);
    }
  }
};

bool Extraction::splat(const ScatterSheet& sheet) const {
  if (points_.empty()) return false;
  Splats splats(sheet, of_lattice_);
  const double infinite = std::numeric_limits<double>::infinity();
  Vec3 low{infinite, infinite, infinite}, high{-infinite, -infinite, -infinite};
  for (const int i : {sheet.x, sheet.x + sheet.width - 1})
    for (const int j : {sheet.y, sheet.y + sheet.height - 1}) {
      const Vec3 corner = splats.at(i, j);
      for (size_t k = 0; k < 3; ++k)
        low[k] = std::min(low[k], corner[k]), high[k] = std::max(high[k], corner[k]);
    }
  std::array<std::array<int, 2>, 3> range;
  for (size_t k = 0; k < 3; ++k)
    range[k] =
        cells_around(k, static_cast<float>(low[k] - paper_reach), static_cast<float>(high[k] + paper_reach));
  // Cells whose ball the sheet passes further away than splats reach are left out.
  const double half_cell = extraction_cell / 2.0, far = paper_reach + std::numbers::sqrt3 * half_cell;
  for (int z = range[2][0]; z <= range[2][1]; ++z)
    for (int y = range[1][0]; y <= range[1][1]; ++y)
      for (int x = range[0][0]; x <= range[0][1]; ++x) {
        const auto index = (static_cast<size_t>(z) * cells_[1] + y) * cells_[0] + x;
        if (start_[index] == start_[index + 1]) continue;
        const Vec3 middle{low_[0] + (2 * x + 1) * half_cell, low_[1] + (2 * y + 1) * half_cell,
                          low_[2] + (2 * z + 1) * half_cell};
        if (std::fabs(dot(splats.normal, middle - splats.origin)) > far) continue;
        for (uint64_t n = start_[index]; n < start_[index + 1]; ++n) splats.add(points_[n]);
      }
  for (int j = 0; splats.any && j < sheet.height; ++j)
    for (int i = 0; i < sheet.width; ++i)
      if (float& v = sheet.values[plane_index(i, j, sheet.pitch)]; v != 0)
        v = static_cast<float>(v / full_sum(splats.at(sheet.x + i, sheet.y + j), nullptr));
  return splats.any;
}

uint64_t Extraction::sample(std::span<const Vec3> uvw, std::span<float> values,
                            std::span<std::array<float, 3>> gradients, const Context& context) const {
  constexpr uint64_t block = 1024;
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  std::atomic<uint64_t> outside{0};
  context.tasks.parallel_for((uvw.size() + block - 1) / block, [&](uint64_t b) {
    context.progress.check();
    uint64_t out = 0;
    for (uint64_t n = b * block; n < std::min<uint64_t>(uvw.size(), (b + 1) * block); ++n) {
      bool inside = true;
      for (size_t i = 0; i < 4; ++i) {
        double p = axes_.origin[i];
        for (size_t k = 0; k < 3; ++k) p += uvw[n][k] * axes_.basis[k][i];
        const double tolerance = domain_tolerance(end_[i]);
        inside = inside && p >= -tolerance && p <= end_[i] + tolerance;
      }
      Vec3 slope{};
      values[n] =
          inside
              ? base_ + static_cast<float>(value(along_.vector(uvw[n]), gradients.empty() ? nullptr : &slope))
              : nan;
      if (!gradients.empty()) {
        slope = along_.transposed(slope);
        for (size_t a = 0; a < 3; ++a) gradients[n][a] = inside ? static_cast<float>(slope[a]) : nan;
      }
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
    sample(plane, {values + z * plane.size(), plane.size()}, {}, context);
  }
}

uint64_t Extraction::list(uint64_t capacity, float* uvw, float* weighted, Progress& progress) const {
  constexpr uint64_t points_per_check = 4096;
  const Affine3 back = along_.inverse();
  for (uint64_t n = 0; n < std::min<uint64_t>(capacity, points_.size()); ++n) {
    if (n % points_per_check == 0) progress.check();
    const Point& p = points_[n];
    if (weighted)
      weighted[n] = p.weighted + (base_ - air_) * std::exp(-static_cast<float>(paper_gaussian) * p.d2);
    if (!uvw) continue;
    const Vec3 at = back.vector({p.at[0], p.at[1], p.at[2]});
    for (size_t k = 0; k < 3; ++k) uvw[3 * n + k] = static_cast<float>(at[k]);
  }
  return points_.size();
}

} // namespace bccsplat
