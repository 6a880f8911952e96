// SPDX-License-Identifier: Apache-2.0
// A host's field, asked for its values on grids.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/context.h"
#include "base/vec.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Writes the values at points x, y, z, t of index space, four numbers each; false: the host gives up.
using Field = std::function<bool(std::span<const double> points, std::span<float> values)>;

// The points origin + step * (i, j, k), i fastest, at a frame index.
struct FieldGrid {
  Vec3 origin{}, step{1, 1, 1};
  Int3 dims{};
  double frame = 0;
};
// The source samples of a frame, and the sites of a layer.
[[nodiscard]] FieldGrid grid_of_frame(const Lattice4& lattice, uint32_t frame);
[[nodiscard]] FieldGrid grid_of_layer(const Lattice4& lattice, int32_t layer);

// Returns the field on a grid. `what` names the field in error texts; throws cancelled when the host gives
// up.
[[nodiscard]] std::vector<float> sample_field(const Field& field, const FieldGrid& grid,
                                              const std::string& what, const Context& context);

} // namespace bccsplat
