// SPDX-License-Identifier: Apache-2.0
// The slow truth: each pixel's ray is integrated in double precision, in fine steps, with the transfer
// function itself, the field's own gradient, and the same laws of shading and compositing as the splatter. It
// does not stop at nearly full opacity.
#pragma once

#include <functional>
#include <memory>

#include "base/context.h"
#include "draw/image.h"
#include "draw/shot.h"
#include "field/lattice_sums.h"

namespace bccsplat {

// The value (absolute) at a point in lattice units, and its gradient per lattice unit unless null.
using FieldAt = std::function<double(const Vec3& point, Vec3* gradient)>;

// Returns the field of a slice; given its lattice sums, gradients are without the ripple of its kernel.
[[nodiscard]] FieldAt slice_field(const Slice& slice, std::shared_ptr<const LatticeSums> sums = nullptr);

// Lattice units: of smooth functions, and of the steepest.
inline constexpr double default_reference_step = 1.0 / 16, finest_reference_step = 1.0 / 128;

struct ReferenceOptions {
  double step = default_reference_step; // lattice units along the view direction
};

// Returns the step for pictures of mode composite: 1/16, finer down to 1/128 where the opacity rises over
// less of the values' range, for the field may run through a good part of it along one lattice unit.
[[nodiscard]] double reference_step(const TransferFunction& function, const std::array<double, 2>& bounds);

// Draws the shot's slice at the image's size. Its view's step is one lattice unit. It draws no trails and no
// deep pictures.
void draw_reference(const Shot& shot, const FieldAt& field, const ReferenceOptions& options,
                    const Context& context, Image& image);

} // namespace bccsplat
