// Slabs: what a slice of some thickness holds, and the quadrature along its normal.
#pragma once

#include <cstdint>
#include <vector>

namespace bccsplat {

// Of the field along the normal: its mean, its integral (value times index units), or its largest value.
enum class SlabKind : uint8_t { mean, sum, maximum };

struct Slab {
  double thickness = 0; // index units along the unit normal, centred on the hyperplane; 0: none
  SlabKind kind = SlabKind::mean;
};

// Gauss-Legendre nodes and weights on [0, 1]; the weights sum to 1.
struct Quadrature {
  std::vector<double> node, weight;
};
[[nodiscard]] Quadrature gauss_legendre(int count);

// Enough for a field that holds what a lattice of density 1 can hold, over a length in index units: a wave
// exp(iwx) over length L converges from w L / 4 nodes on, which is .79 L at the Nyquist frequency.
[[nodiscard]] int slab_nodes(double length);

} // namespace bccsplat
