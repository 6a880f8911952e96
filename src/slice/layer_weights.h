// SPDX-License-Identifier: Apache-2.0
// How much each layer of a series counts in a moment of it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "kernel/kernel.h"
#include "lattice/lattice.h"

namespace bccsplat {

struct LayerWeight {
  int32_t layer; // may lie beyond the ends: the mirror image counts
  float weight;
};

// These return the layers of both cosets that take part in the instant `frame`, or in the mean over [begin,
// end] (frames, begin < end). A normalised kernel divides by the sum over all layers of the coset. A static
// lattice has one layer per coset.
[[nodiscard]] std::vector<LayerWeight> instant_weights(const Lattice4& lattice, const Kernel& kernel,
                                                       double frame);
[[nodiscard]] std::vector<LayerWeight> mean_weights(const Lattice4& lattice, const Kernel& kernel,
                                                    double begin, double end);

// Returns the layer that stands at the instant `frame`, if one does.
[[nodiscard]] std::optional<int32_t> layer_at(const Lattice4& lattice, double frame);

[[nodiscard]] std::vector<int32_t> layers_of(const std::vector<LayerWeight>& weights);
[[nodiscard]] std::vector<int32_t> all_layers(const Lattice4& lattice);

// Returns the part of [begin, end] that lies in the series; of a periodic one that lies in it or in a turn
// before or behind.
[[nodiscard]] std::array<double, 2> time_span(const Lattice4& lattice, double begin, double end);

} // namespace bccsplat
