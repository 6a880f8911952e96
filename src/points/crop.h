// SPDX-License-Identifier: Apache-2.0
// A box of sites of a layer, as a layer of its own.
#pragma once

#include "points/brick.h"

namespace bccsplat {

// Returns the sites from `first` on, as many as a layer of `lattice` of the same coset has.
[[nodiscard]] BrickLayer crop_layer(const BrickLayer& layer, const Lattice3& lattice, const Int3& first);

} // namespace bccsplat
