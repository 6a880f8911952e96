// SPDX-License-Identifier: Apache-2.0
#include "kernel/autocorrelation.h"

#include <cmath>
#include <numbers>

namespace bccsplat {

double autocorrelation(const RadialKernel& phi, double distance) {
  // The integral is taken in cylinders around d: z runs along it, r away from it.
  constexpr int steps = 64; // of r; z has steps of the same length
  const double h = phi.radius / steps;
  double sum = 0;
  for (int j = 0; j < steps; ++j) {
    const double r = (j + 0.5) * h;
    for (int i = 0; i < 2 * steps; ++i) {
      const double z = (i + 0.5) * h - phi.radius;
      sum += r * phi.value(r * r + z * z) * phi.value(r * r + (z - distance) * (z - distance));
    }
  }
  return 2 * std::numbers::pi * h * h * sum;
}

double autocorrelation(const TemporalKernel& beta, double dt) {
  constexpr int steps = 512;
  const double h = 2 * beta.half_width / steps;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) * h - beta.half_width;
    sum += beta.value(t) * beta.value(t + dt);
  }
  return h * sum;
}

} // namespace bccsplat
