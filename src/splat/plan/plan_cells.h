// Which cells of a brick, 4^3 planes of the lattice, a picture needs, by what the coefficients in and around
// them can amount to.
#pragma once

#include <cstdint>

#include "splat/plan/plan.h"

namespace bccsplat {

// Between what the sum of kernel weights over the sites stays: on BCC the radial kernels and their other
// forms ripple by 1 % at most, the others by 8.6 % (the paper's). Its mean is at least 1.
struct WeightBounds {
  double least, most;
  explicit WeightBounds(const Slice& slice);
};

// Whether samples may show that lie between points with coefficients low .. high (and 0) only: whether points
// are left out or not, the field is within their range there.
[[nodiscard]] bool shows(const SplatScene& scene, const SplatOptions& options, const WeightBounds& weights,
                         float low, float high);
// How far the samples that gradients or crossings of a visible sample look at may stand from it, lattice
// units.
[[nodiscard]] double look_distance(const SplatScene& scene, const SplatOptions& options,
                                   const SplatPlan& plan);
// The cells of a brick that samples in the domain, up to a sheet beyond it, may look at.
[[nodiscard]] uint64_t near_cells(const SplatScene& scene, const SplatBrick& brick, double look);
// Which of SplatPoints::cells tells whether a cell's points are needed, -1: neither reaches far enough.
// Points change samples within a radius; of those that gradients or crossings of visible samples look at none
// may be changed, and none is when all coefficients within another radius of them are known to be invisible.
[[nodiscard]] int useful_cells(const SplatScene& scene, const SplatOptions& options, const SplatPlan& plan);
// A sample whose points are left out because they are beyond the surface, and those it is compared with, are
// all known to be beyond it; InsideCells tells so when it comes out too low.
[[nodiscard]] uint64_t needed_cells(const SplatScene& scene, const SplatOptions& options,
                                    const WeightBounds& weights, const CellRange* range, bool inside);
// The cells of a brick whose samples are all beyond the isosurface, by the ranges around them.
[[nodiscard]] uint64_t inside_cells(const SplatScene& scene, double iso_value, const WeightBounds& weights,
                                    const CellRange* range);

} // namespace bccsplat
