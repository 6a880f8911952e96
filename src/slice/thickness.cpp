// SPDX-License-Identifier: Apache-2.0
#include "slice/thickness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace bccsplat {
namespace {

// Nodes per index unit: about twice what a wave at the Nyquist frequency converges with (thickness.h). Up to
// dense_from that is enough, with a third more nodes than such a density converges with. Short lengths need a
// few nodes more.
constexpr double nodes_per_unit = 1.5, dense_from = 1.43;
constexpr int more_nodes = 3;
// A node costs an evaluation at every site of the slice, so a thicker cut is a mistake in its units.
constexpr double thickest = 2000;

} // namespace

// Newton's method on the Legendre polynomial (Abramowitz & Stegun 25.4.29, with 22.7.10 for P_n).
Quadrature gauss_legendre(int count) {
  Quadrature q;
  q.node.resize(count), q.weight.resize(count);
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5)), slope = 1;
    for (int step = 0; step < 100; ++step) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= count; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1, p1 = p2;
      }
      slope = count * (x * p1 - p0) / (x * x - 1);
      const double change = p1 / slope;
      x -= change;
      if (std::fabs(change) < 1e-15) break;
    }
    const size_t place = count - 1 - i;
    q.node[place] = (1 + x) / 2;
    sum += q.weight[place] = 1 / ((1 - x * x) * slope * slope);
  }
  for (double& w : q.weight) w /= sum;
  return q;
}

int thickness_nodes(double length, double density) {
  if (!(length < thickest)) fail(Code::limit_exceeded, "slice: thicker than 2000 samples");
  const double per_unit = nodes_per_unit * std::max(1.0, density / dense_from);
  return static_cast<int>(std::ceil(per_unit * length)) + more_nodes;
}

} // namespace bccsplat
