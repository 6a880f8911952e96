// SPDX-License-Identifier: Apache-2.0
// Integrates a transfer function over the value, piece by piece between its points so that no step of it is
// missed, and measures how much the integrals would change a picture.
#include "shade/preintegrate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shade/surface.h"

namespace bccsplat {
namespace {

// The largest extinction, per unit distance: a shell of full opacity a thousandth of a step thick is opaque
// still.
constexpr double most_extinction = 1e6;
// Integrals up to this optical depth per unit distance are one float each. Beyond it half a unit in the last
// place, spread over the one entry that a segment reaches over at least, shows beside an optical depth of 1.
constexpr double one_float_integral = 1e4;

// Returns the values at which the function has points, rising.
std::vector<double> knots(const TransferFunction& function) {
  std::vector<double> values;
  for (const ColorPoint& p : function.colors) values.push_back(p.value);
  for (const OpacityPoint& p : function.opacities) values.push_back(p.value);
  std::sort(values.begin(), values.end());
  return values;
}

using Emission = std::array<double, 4>; // colour * extinction, extinction

Emission emission_at(const TransferFunction& function, double value, double unit) {
  const double absorbs = std::min(extinction(function.opacity(value), unit), most_extinction / unit);
  const Vec3 color = function.color(value);
  return {color[0] * absorbs, color[1] * absorbs, color[2] * absorbs, absorbs};
}

// Returns the mean between two values that no point of the function lies between, by Gauss-Legendre
// quadrature, which never asks at the ends.
Emission mean_inside(const TransferFunction& function, double from, double to, double unit) {
  constexpr std::array<double, 3> place{-0.7745966692414834, 0, 0.7745966692414834};
  constexpr std::array<double, 3> weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
  Emission sum{};
  for (size_t n = 0; n < 3; ++n) {
    const Emission e = emission_at(function, 0.5 * (from + to) + 0.5 * place[n] * (to - from), unit);
    for (size_t c = 0; c < 4; ++c) sum[c] += weight[n] * e[c];
  }
  return sum;
}

Emission of_entry(const std::array<float, 4>& entry) {
  Emission e;
  for (size_t c = 0; c < 3; ++c) e[c] = static_cast<double>(entry[c]) * entry[3];
  e[3] = entry[3];
  return e;
}

std::array<float, 4> rounded(const Emission& e) {
  return {static_cast<float>(e[0]), static_cast<float>(e[1]), static_cast<float>(e[2]),
          static_cast<float>(e[3])};
}

} // namespace

ValueIntegrals integrate_values(const TransferFunction& function, const ClassTable& table) {
  ValueIntegrals t;
  const int entries = table.size();
  if (entries < 2) return t;
  const std::vector<double> points = knots(function);
  const double low = table.low, step = 1 / static_cast<double>(table.scale), unit = table.unit_distance;
  Emission sum{};
  double moment = 0;
  const auto add = [&](const Emission& mean) {
    const std::array<float, 4> head = rounded(sum);
    Emission rest;
    for (size_t c = 0; c < 4; ++c) rest[c] = sum[c] - head[c];
    t.part.insert(t.part.end(), {head, rounded(rest), rounded(mean)});
    const auto first = static_cast<float>(moment);
    t.moment.push_back({first, static_cast<float>(moment - first), 0, 0});
  };
  const auto cut = [&](Emission mean) {
    for (double& m : mean) m = std::min(m, most_extinction / unit);
    return mean;
  };
  add(cut(of_entry(table.entry.front())));
  auto next = std::upper_bound(points.begin(), points.end(), low);
  for (int j = 1; j < entries; ++j) {
    const double from = low + (j - 1) * step, to = low + j * step;
    Emission mean{};
    for (double a = from; a < to;) {
      while (next != points.end() && *next <= a) ++next;
      const double b = next != points.end() ? std::min(*next, to) : to;
      const Emission part = mean_inside(function, a, b, unit);
      for (size_t c = 0; c < 4; ++c) mean[c] += part[c] * (b - a) / step;
      a = b;
    }
    add(mean);
    for (size_t c = 0; c < 4; ++c) sum[c] += mean[c];
    moment += mean[3] * (j - 0.5);
  }
  add(cut(of_entry(table.entry.back())));
  t.split = sum[3] * unit > one_float_integral;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  t.next_visible.assign(static_cast<size_t>(entries) + 2, entries + 1);
  t.first = infinity, t.last_end = -infinity;
  for (int j = entries; j >= 0; --j) {
    const size_t n = j;
    t.next_visible[n] = t.next_visible[n + 1];
    if (!(t.part[3 * n + 2][3] > 0)) continue;
    t.next_visible[n] = j;
    t.first = j == 0 ? -infinity : static_cast<float>(j - 1);
    t.last_end = std::max(t.last_end, j == entries ? infinity : static_cast<float>(j));
  }
  return t;
}

double narrowness(const TransferFunction& function, const ClassTable& table, double change, double path) {
  const std::ptrdiff_t entries = table.size();
  const auto reach = static_cast<std::ptrdiff_t>(
      std::min(std::ceil(0.5 * change * table.scale), static_cast<double>(entries)));
  if (entries < 2 || reach < 1) return 0;
  // Integrals up to each entry, by trapezia; beyond the ends the function goes on as it ends.
  std::vector<Emission> integral(table.entry.size());
  for (size_t i = 1; i < integral.size(); ++i) {
    const Emission a = of_entry(table.entry[i - 1]), b = of_entry(table.entry[i]);
    for (size_t c = 0; c < 4; ++c) integral[i][c] = integral[i - 1][c] + 0.5 * (a[c] + b[c]);
  }
  const auto up_to = [&](std::ptrdiff_t i, size_t c) {
    const std::ptrdiff_t in = std::clamp<std::ptrdiff_t>(i, 0, entries - 1);
    return integral[in][c] + static_cast<double>(i - in) * of_entry(table.entry[in])[c];
  };
  const auto shown = [path](Emission e) {
    const double opacity = -std::expm1(-e[3] * path), share = e[3] > 0 ? opacity / e[3] : 0;
    return Emission{e[0] * share, e[1] * share, e[2] * share, opacity};
  };
  double most = 0, most_color = 0, opacity = 0, color = 0;
  const auto compare = [&](std::ptrdiff_t i, const Emission& at_middle) {
    Emission mean;
    for (size_t c = 0; c < 4; ++c)
      mean[c] = (up_to(i + reach, c) - up_to(i - reach, c)) / static_cast<double>(2 * reach);
    const Emission segment = shown(mean), middle = shown(at_middle);
    opacity = std::max(opacity, middle[3]);
    most = std::max(most, std::fabs(segment[3] - middle[3]));
    for (size_t c = 0; c < 3; ++c) {
      color = std::max(color, middle[c]);
      most_color = std::max(most_color, std::fabs(segment[c] - middle[c]));
    }
  };
  for (std::ptrdiff_t i = 0; i < entries; ++i) compare(i, of_entry(table.entry[i]));
  // A peak between two entries is in none of them.
  for (const double value : knots(function)) {
    const double place = (value - table.low) * table.scale;
    if (place < 0 || place > static_cast<double>(entries - 1)) continue;
    compare(static_cast<std::ptrdiff_t>(std::nearbyint(place)),
            emission_at(function, value, table.unit_distance));
  }
  return std::max(opacity > 0 ? most / opacity : 0, color > 0 ? most_color / color : 0);
}

} // namespace bccsplat
