// SPDX-License-Identifier: Apache-2.0
// Sums of kernel-weighted coefficients around points: the inner loop of every evaluation.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/vec.h"
#include "field/footprint/patch.h"
#include "kernel/kernel.h"
#include "points/brick.h"

namespace bccsplat {

// A layer that takes part, at its place in kernel time (below). Slices have one layer per coset and no time.
struct FieldLayer {
  const BrickLayer* layer;
  double time = 0;
};

// Layers of the cosets of one lattice, with the kernel that weighs them. Within a coset they are in order
// of time, one pitch apart. Kernel time is measured so that this pitch is sqrt2, on every lattice.
struct FieldLayers {
  std::span<const FieldLayer> layers;
  const Kernel* kernel;
  bool timeless = true; // every layer weighs 1; one per coset
};

inline constexpr int max_stack = 4; // layers of a coset within reach of an instant: no kernel has more

// A field as the inner loop needs it, made once and used for any number of points. Lengths are in coset
// pitches. The layers and the kernel must outlive it.
struct FootprintPlan {
  struct Coset {
    std::vector<const BrickLayer*> layer;
    std::vector<const std::shared_ptr<const Brick>*> bricks; // of each layer, by slot
    Int3 dims{}, brick_dims{};
    alignas(32) Vec4 origin{}; // a point at p lies at p * per_pitch + origin
  };
  std::array<Coset, 2> coset;
  int cosets = 0;
  const Kernel* kernel;
  bool timeless, bcc = true;
  int edge = patch_edge;       // 3 or 4 sites per axis
  int depth = 1;               // layers of a coset in reach of an instant
  std::array<float, 2> bend{}; // of the temporal spline
  alignas(32) Vec4 per_pitch{};
  alignas(32) Vec4 radius{}; // of the kernel in space and time
  float inverse_radius2 = 0;
  int terms = 0;
  bool contact = false; // a[0] = a[1] = 0 and nothing beyond a[7]: phi and its slope end at 0
  std::array<float, RadialKernel::max_terms> a{};

  explicit FootprintPlan(const FieldLayers& field);
};

// Weights of layers in time, and their slopes per pitch, from the kernel itself: any shape, normalised or
// not.
void weigh_by_kernel(const FootprintPlan& plan, float from, std::array<float, max_stack>& w,
                     std::array<float, max_stack>& dw);
// Divides a value by the lattice sum at p, and corrects its gradient.
void divide_by_lattice_sum(const FootprintPlan& plan, const Vec4& p, float& value,
                           std::array<float, 4>* gradient);

// Sums coefficients times kernel at each point p (x, y, z in lattice units, kernel time; inside the domain):
// values are relative to air, divided by the lattice sum for normalised kernels; gradients (may be null) are
// the four derivatives per unit of p.
void sum_footprints(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients);
void sum_footprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients);

} // namespace bccsplat
