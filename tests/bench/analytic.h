// SPDX-License-Identifier: Apache-2.0
// Fields whose value and gradient are known everywhere: what pictures are compared with.
#pragma once

#include <functional>

#include "base/vec.h"

namespace bccsplat::bench {

// Value at a point in index space, and its gradient per index unit unless null.
using AnalyticField = std::function<double(const Vec3& p, Vec3* gradient)>;

// Marschner & Lobb 1994 on [0, n-1]^3, in [0, 1]. 40 samples hold 6 cycles, as in the original on 41^3,
// whatever n: as hard per sample, 0.94 of the Nyquist rate along x and y. Not band limited.
[[nodiscard]] AnalyticField marschner_lobb(double n);
// Of so many cycles.
[[nodiscard]] AnalyticField marschner_lobb(double n, double cycles);

// The same with J0(rho pi R), R in index units from the axis, instead of the chirp: spherically band limited
// to |w| <= rho pi.
[[nodiscard]] AnalyticField bessel_rings(double n, double rho);

// Puffs of smoke that drift, swell and turn, as they are at frame t: 0 outside of them, about 5 % of
// [0, n-1]^3 inside, twice differentiable. Values 0 .. about 1.
[[nodiscard]] AnalyticField puffs(double n, double t);

// A sum of sines in 12 directions, 8 to 60 index units long: as much everywhere, in [0, 1] and mostly near
// 1/2.
[[nodiscard]] AnalyticField waves();

} // namespace bccsplat::bench
