// SPDX-License-Identifier: Apache-2.0
// Arrows with names along the axes: those of the world, time among them, or of a slice that is aslant to
// them.
#pragma once

#include "tool/annotate/projection.h"
#include "tool/annotate/world_names.h"

namespace bcc4 {

// Around `origin`, in pixels; em: of the names. names: of the ends of the volume's axes, in place of x, y, z.
void draw_axes(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
               const bccsplat_volume_info& volume, const std::optional<WorldNames>& names,
               const Point& origin, double em, const Ink& ink);

} // namespace bcc4
