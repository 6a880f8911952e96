// SPDX-License-Identifier: Apache-2.0
// Stills of a trail as sums of the lattice's layers.
#pragma once

#include <vector>

#include "scene/trail.h"

namespace bccsplat {

// An instant and its share of the trail.
struct Moment {
  double at = 0; // frame, or index units along the normal from the slice
  double weight = 1;
  int interval = 0;
};

void add_source(Trail& trail, Slice&& slice, const Context& context);

// Adds the moments (frames) with the layers as their sources. Returns false, and does nothing, when that
// would be dearer than the stills, or where there are holes, masks or corrections: those of a still are not
// those of its layers. `like` is a time slice of the volume.
bool add_layers(Trail& trail, const Coefficients& coefficients, const Slice& like,
                const std::vector<Moment>& moments, const Context& context);

} // namespace bccsplat
