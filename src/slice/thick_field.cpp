// SPDX-License-Identifier: Apache-2.0
#include "slice/thick_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "field/evaluate.h"
#include "slice/gaussian_mean.h"
#include "slice/plane_geometry.h"

namespace bccsplat {

ThickField::ThickField(const Coefficients& coefficients, const Hyperplane& h, const Thickness& thickness,
                       const std::optional<Vec4>& bandwidth)
    : coefficients_(coefficients), normal_(h.normal()), thickness_(thickness), bandwidth_(bandwidth) {
  const Lattice4& lattice = coefficients.source().lattice();
  double diagonal = 0; // no line through the domain is longer
  for (size_t i = 0; i < 4; ++i) {
    end_[i] = lattice.domain_end(i);
    diagonal = std::hypot(diagonal, end_[i]);
  }
  if (thickness.length > 0)
    nodes_ = gauss_legendre(
        thickness_nodes(std::min(thickness.length, diagonal), lattice_density(lattice, normal_)));
}

void ThickField::values(std::span<const Vec4> points, std::span<float> out, std::span<uint8_t> holes,
                        const Context& context) const {
  if (bandwidth_)
    return gaussian_means(coefficients_.source(), coefficients_.channel(), *bandwidth_, points, out, context);
  if (nodes_.node.empty()) return evaluate4_mirrored(coefficients_, points, out, {}, holes, context);
  // Points beyond the ends are moved to their mirror images, whose lines run inside.
  std::vector<Vec4> inside(points.begin(), points.end()), at(points.size());
  std::vector<std::array<double, 2>> stretch(points.size());
  for (size_t n = 0; n < points.size(); ++n) stretch[n] = clip(inside[n]);
  std::vector<double> sum(points.size());
  std::vector<float> some(points.size());
  std::fill(out.begin(), out.end(), -std::numeric_limits<float>::infinity());
  const double part = 1 / static_cast<double>(nodes_.node.size() + 1);
  for (size_t k = 0; k < nodes_.node.size(); ++k) {
    const auto node = static_cast<double>(k);
    Progress share(context.progress, node * part, (node + 1) * part);
    for (size_t n = 0; n < points.size(); ++n) {
      const double s = stretch[n][0] + (stretch[n][1] - stretch[n][0]) * nodes_.node[k];
      for (size_t i = 0; i < 4; ++i) at[n][i] = inside[n][i] + s * normal_[i];
    }
    evaluate4_mirrored(coefficients_, at, some, {}, {}, context.with(share));
    for (size_t n = 0; n < points.size(); ++n) {
      sum[n] += nodes_.weight[k] * some[n];
      out[n] = std::max(out[n], some[n]);
    }
  }
  // A point of the hyperplane itself decides what is a hole.
  Progress last(context.progress, 1 - part, 1);
  evaluate4_mirrored(coefficients_, points, some, {}, holes, context.with(last));
  const double base = coefficients_.base();
  for (size_t n = 0; n < points.size(); ++n) {
    const double length = stretch[n][1] - stretch[n][0];
    if (thickness_.kind == ThicknessKind::mean) out[n] = static_cast<float>(sum[n]);
    if (thickness_.kind == ThicknessKind::sum)
      out[n] = static_cast<float>(sum[n] * length + base * (length - thickness_.length));
  }
}

// Moves a point into the domain and returns the part of its line that lies in thickness and domain.
std::array<double, 2> ThickField::clip(Vec4& p) const {
  std::array<double, 2> s{-thickness_.length / 2, thickness_.length / 2};
  for (size_t i = 0; i < 4; ++i) {
    if (coefficients_.source().lattice().turns(i)) continue; // what is beyond goes on
    p[i] = std::fabs(p[i]);
    if (p[i] > end_[i]) p[i] = std::max(0.0, 2 * end_[i] - p[i]);
    if (normal_[i] == 0) continue;
    const double a = -p[i] / normal_[i], b = (end_[i] - p[i]) / normal_[i];
    s[0] = std::max(s[0], std::min(a, b)), s[1] = std::min(s[1], std::max(a, b));
  }
  return s;
}

} // namespace bccsplat
