// SPDX-License-Identifier: Apache-2.0
// What a slice with thickness holds of the field along its normal, and the quadrature for it.
#pragma once

#include <cstdint>
#include <vector>

namespace bccsplat {

// The field along the normal becomes its mean, its integral (value times index units), or its largest value.
enum class ThicknessKind : uint8_t { mean, sum, maximum };

struct Thickness {
  double length = 0; // index units along the unit normal, centred on the hyperplane; 0: none
  ThicknessKind kind = ThicknessKind::mean;
};

// Gauss-Legendre nodes and weights on [0, 1], whose weights sum to 1.
struct Quadrature {
  std::vector<double> node, weight;
};
[[nodiscard]] Quadrature gauss_legendre(int count);

// Returns how many nodes are enough over a length in index units, of a field that a lattice can hold whose
// density along it is `density` (lattice_density()): a wave exp(iwx) over length L converges from w L / 4
// nodes on, which is 0.79 L at the Nyquist frequency, density 1.
[[nodiscard]] int thickness_nodes(double length, double density);

} // namespace bccsplat
