// Sums of kernel-weighted coefficients around points: the inner loop of every evaluation.
#pragma once

#include <array>
#include <span>

#include "base/vec.h"
#include "kernel/kernel.h"
#include "points/brick.h"

namespace bccsplat {

// A layer that takes part, at its place in time (lattice units). Slices have one layer per coset and no time.
struct FieldLayer {
  const BrickLayer* layer;
  double time = 0;
};

// Layers of both cosets of one lattice, with the kernel that weighs them.
struct FieldLayers {
  std::span<const FieldLayer> layers;
  const Kernel* kernel;
  bool timeless = true; // every layer weighs 1
};

// At each point p (x, y, z, t in lattice units, inside the domain): values = sum of coefficients times
// kernel, relative to air, divided by the lattice sum for normalised kernels. gradients (may be null): the
// four derivatives per lattice unit.
void sum_footprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients);

} // namespace bccsplat
