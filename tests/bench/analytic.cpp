// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/analytic.h"

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace bccsplat::bench {
namespace {

using std::numbers::pi;

// (1 - sin(pi w / 2) + a (1 + rho)) / (2 (1 + a)), w in [-1, 1] along z; `ripple` gives rho and d rho / dR at
// the distance R from the axis in index units.
template<class Ripple> AnalyticField rippled(double n, Ripple ripple) {
  return [=](const Vec3& p, Vec3* gradient) {
    constexpr double a = 0.25, scale = 1 / (2 * (1 + a));
    const double half = (n - 1) / 2, w = p[2] / half - 1;
    const double x = p[0] - half, y = p[1] - half, radius = std::hypot(x, y);
    const auto [rho, slope] = ripple(radius);
    if (gradient) {
      const double g = radius > 0 ? scale * a * slope / radius : 0;
      *gradient = {g * x, g * y, -scale * pi / 2 * std::cos(pi * w / 2) / half};
    }
    return scale * (1 - std::sin(pi * w / 2) + a * (1 + rho));
  };
}

} // namespace

AnalyticField marschner_lobb(double n) { return marschner_lobb(n, 6 * (n - 1) / 40); }

AnalyticField marschner_lobb(double n, double cycles) {
  const double half = (n - 1) / 2;
  return rippled(n, [=](double radius) {
    const double r = radius / half, phase = 2 * pi * cycles * std::cos(pi * r / 2);
    return std::array{std::cos(phase), std::sin(phase) * pi * pi * cycles * std::sin(pi * r / 2) / half};
  });
}

AnalyticField bessel_rings(double n, double rho) {
  const double k = rho * pi;
  return rippled(n, [=](double radius) {
    return std::array{std::cyl_bessel_j(0.0, k * radius), -k * std::cyl_bessel_j(1.0, k * radius)};
  });
}

AnalyticField puffs(double n, double t) {
  struct Puff {
    Vec3 centre;
    double radius, turn;
  };
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Puff> all;
  for (int i = 0; i < 10; ++i) {
    Puff p;
    for (double& c : p.centre) c = (0.2 + 0.6 * uniform(random)) * n + 0.5 * (uniform(random) - 0.5) * t;
    p.radius = (0.08 + 0.06 * uniform(random)) * n + 0.02 * uniform(random) * t;
    p.turn = (0.25 + 0.25 * uniform(random)); // radians per index unit
    all.push_back(p);
  }
  return [=](const Vec3& p, Vec3* gradient) {
    double sum = 0;
    if (gradient) *gradient = {};
    for (const Puff& puff : all) {
      const Vec3 d = p - puff.centre;
      const double r2 = puff.radius * puff.radius, u = 1 - dot(d, d) / r2;
      if (u <= 0) continue;
      const double a = puff.turn * (d[0] + 0.7 * d[1]) + 0.2 * t, b = puff.turn * d[2];
      const double wave = 0.7 + 0.3 * std::sin(a) * std::cos(b);
      sum += u * u * u * wave;
      if (!gradient) continue;
      const double along = 0.3 * puff.turn * std::cos(a) * std::cos(b);
      const Vec3 turn{along, 0.7 * along, -0.3 * puff.turn * std::sin(a) * std::sin(b)};
      *gradient = *gradient + (-6 * u * u * wave / r2) * d + (u * u * u) * turn;
    }
    return sum;
  };
}

AnalyticField waves() {
  struct Wave {
    Vec3 k;
    double phase;
  };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Wave> all;
  while (all.size() < 12) {
    const Vec3 direction{uniform(random), uniform(random), uniform(random)};
    if (length(direction) > 1 || length(direction) < 0.1) continue;
    const double wavelength = 34 + 26 * uniform(random);
    all.push_back({2 * pi / wavelength * normalized(direction), 3 * uniform(random)});
  }
  return [=](const Vec3& p, Vec3* gradient) {
    const double each = 0.5 / static_cast<double>(all.size());
    double sum = 0.5;
    if (gradient) *gradient = {};
    for (const Wave& w : all) {
      const double at = dot(w.k, p) + w.phase;
      sum += each * std::sin(at);
      if (gradient) *gradient = *gradient + (each * std::cos(at)) * w.k;
    }
    return sum;
  };
}

} // namespace bccsplat::bench
