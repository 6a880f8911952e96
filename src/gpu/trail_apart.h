// SPDX-License-Identifier: Apache-2.0
// A trail whose slice is a picture of its own: a surface that ends the trail's rays, or what is laid over it.
#pragma once

#include <vector>

#include "draw/shot.h"
#include "gpu/gpu_picture.h"

namespace bccsplat {

// The planar distances at which rays end at a surface, or where `ends` (empty: nowhere) says before that.
[[nodiscard]] std::vector<float> ends_at(const GpuPixels& surface, const SheetView& view,
                                         const std::vector<float>& ends);
// Adds the surface behind what was drawn up to it.
void add_surface(const GpuPixels& surface, const ShotOptions& options, GpuPixels& onto);
// Lays a finished picture over another.
void lay_over(const GpuPixels& front, GpuPixels& onto);

} // namespace bccsplat
