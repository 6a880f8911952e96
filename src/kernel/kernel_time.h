// SPDX-License-Identifier: Apache-2.0
// Kernel time: the unit in which temporal kernels are given. The layers of one coset are sqrt2 apart on every
// lattice; on D4* this is the lattice unit.
#pragma once

#include <numbers>

#include "kernel/kernel.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Returns the distance of neighbouring layers.
[[nodiscard]] inline double kernel_time_per_layer(const Lattice4& lattice) {
  return std::numbers::sqrt2 / lattice.layer_period();
}

// Returns the kernel time of one frame; 1 for a static lattice, which has no time.
[[nodiscard]] inline double kernel_time_per_frame(const Lattice4& lattice) {
  return lattice.is_static() ? 1 : kernel_time_per_layer(lattice) / lattice.time_step;
}

// Returns the kernel time of a layer, from frame 0 on.
[[nodiscard]] inline double kernel_time_of_layer(const Lattice4& lattice, int32_t layer) {
  return (layer - lattice.lead) * kernel_time_per_layer(lattice);
}

// Layers closer than this to an instant take part. A layer at the very edge of the support does not, however
// its distance is rounded: truncated Gaussians jump there.
[[nodiscard]] inline double time_reach(const Kernel& kernel) { return kernel.time.half_width - 1e-9; }

} // namespace bccsplat
