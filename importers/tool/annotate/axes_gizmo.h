// SPDX-License-Identifier: Apache-2.0
// Arrows with names along the axes: those of the world, or of a slice that is not a moment.
#pragma once

#include "tool/annotate/projection.h"

namespace bcc4 {

// Around `origin`, in pixels; em: of the names.
void draw_axes(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
               bool is_time_slice, const Point& origin, double em, const Ink& ink);

} // namespace bcc4
