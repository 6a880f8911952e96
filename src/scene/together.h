// SPDX-License-Identifier: Apache-2.0
// Several slices in one picture, right in depth: where they overlap their extinctions add, and their colours
// mix by them.
#pragma once

#include <span>

#include "scene/picture.h"

namespace bccsplat {

// The slices share their sheets: their sights, alike but for clips, say the same point that sheet 0 passes
// through (Sight::sheets_meet). Isosurfaces, and slices so much finer than others that these would have too
// many sheets, are drawn as deep pictures and merged. Throws what render() does, and unsupported for planes
// of values and times, for modes xray and maximum, and for a deep picture of what does not share its sheets.
// Returns what drew it, and why a GPU did not.
RenderStats render_together(std::span<const Scene> scenes, const RenderOptions& options,
                            const Context& context, Image& image);

} // namespace bccsplat
