// Stills of a trail as sums of the lattice's layers.
#pragma once

#include <vector>

#include "render/trail.h"

namespace bccsplat {

// An instant and how much of the trail it stands for.
struct Moment {
  double at = 0; // frame, or index units along the normal from the slice
  double weight = 1;
  int interval = 0;
};

void add_source(Trail& trail, Slice&& slice, const Context& context);

// Adds the moments (frames) with the layers as their sources. False, and nothing done, when that would be
// dearer than the stills, or where holes or corrections are: those of a still are not of its layers. like:
// a time slice of the volume.
bool add_layers(Trail& trail, const Coefficients& coefficients, const Slice& like,
                const std::vector<Moment>& moments, const Context& context);

} // namespace bccsplat
