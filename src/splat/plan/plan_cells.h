// SPDX-License-Identifier: Apache-2.0
// Which cells of a brick, 4^3 planes of the lattice, a picture needs, by what the coefficients in and around
// them can amount to.
#pragma once

#include <cstdint>
#include <optional>

#include "splat/plan/plan.h"

namespace bccsplat {

// The sum of kernel weights over the sites stays between these bounds: on BCC the radial kernels and their
// other forms ripple by 1 % at most, the others by 8.6 % (the paper's). Its mean is at least 1.
struct WeightBounds {
  double least, most;
  explicit WeightBounds(const Slice& slice);
};

// Returns whether samples may show that lie between points with coefficients low .. high (and 0) only. The
// field there is within the range that follows from these, whether points are left out or not.
[[nodiscard]] bool shows(const SplatScene& scene, const SplatOptions& options, const WeightBounds& weights,
                         float low, float high);
// Returns how far from a visible sample those may be that its gradient or crossing looks at, lattice units.
[[nodiscard]] double look_distance(const SplatScene& scene, const SplatOptions& options,
                                   const SplatPlan& plan);
// Returns the cells of a brick that samples in the domain, up to a sheet beyond it, may look at.
[[nodiscard]] uint64_t near_cells(const SplatScene& scene, const SplatBrick& brick, double look);
// Returns which of SplatPoints::cells tells whether a cell's points are needed; -1 when none reaches far
// enough. Points change samples within a radius; of those that gradients or crossings of visible samples look
// at none may be changed, and none is when all coefficients within another radius of them are known to be
// invisible.
[[nodiscard]] int useful_cells(const SplatScene& scene, const SplatOptions& options, const SplatPlan& plan);
// Returns the value of the isosurfaces that is furthest from the base, relative to it; none where they lie on
// both sides of it.
[[nodiscard]] std::optional<double> furthest_surface(const SplatScene& scene, const SplatOptions& options);
// A sample whose points are left out because they are beyond all surfaces, and those it is compared with, are
// all known to be beyond them; InsideCells says so when it comes out too low. inside: furthest_surface();
// none: nothing is left out for that.
[[nodiscard]] uint64_t needed_cells(const SplatScene& scene, const SplatOptions& options,
                                    const WeightBounds& weights, const CellRange* range,
                                    const std::optional<double>& inside);
// Returns the cells of a brick whose samples are all beyond the isosurfaces, by the ranges around them.
[[nodiscard]] uint64_t inside_cells(double furthest, const WeightBounds& weights, const CellRange* range);

} // namespace bccsplat
