// SPDX-License-Identifier: Apache-2.0
// How fast the values of a slice change, so that a picture knows whether it needs integrals of its classes.
#pragma once

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

// Returns how much values change along a lattice unit where they change fast: the 95th percentile of the
// gradient's length at some hundred sites. It is the slice's own, whatever was drawn before; of a moment
// nothing is merged for it.
[[nodiscard]] double change_at_sites(const Slice& slice, const Context& context);

} // namespace bccsplat
