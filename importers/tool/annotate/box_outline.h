// SPDX-License-Identifier: Apache-2.0
// The edges of a slice's domain: those behind it under the picture, those before it over it.
#pragma once

#include "tool/annotate/projection.h"

namespace bcc4 {

void draw_box(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
              double thickness, const Color& color);
// The middle of a slice's domain in the world.
[[nodiscard]] Vector domain_centre(const bccsplat_slice_info& slice);

} // namespace bcc4
