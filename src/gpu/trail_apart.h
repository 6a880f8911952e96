// SPDX-License-Identifier: Apache-2.0
// A trail behind a surface, which is drawn first and ends the trail's rays.
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

} // namespace bccsplat
