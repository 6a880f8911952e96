// SPDX-License-Identifier: Apache-2.0
// An opaque isosurface without points and sheets: rays sample the field at whole sheets,
// in cells that may hold the value, and find roots and turning points as sheets have them.
//
// Which cells these are is proven (cell_bound.h), so that no pixel differs from a search of all of them.
// tests/bench/notes/isosurfaces.md has the measurements.
#pragma once

#include <functional>

#include "base/context.h"
#include "splat/plan/scene.h"
#include "splat/plan/stats.h"
#include "splat/rays/ray_search.h"
#include "splat/tile/tile_pixels.h"

namespace bccsplat {

// Returns whether rays draw a picture of this slice in this view: a time slice on BCC by a kernel with a
// bound, all of whose domain has a field without holes, masks, corrections, clips and periodic axes; a view
// that is not too wide for its pixels (find_ray_axes()), one opaque surface, not deep. The scene needs no
// points then.
[[nodiscard]] bool rays_cover(const Slice& slice, const SheetView& view, const SplatOptions& options);

// Draws such a picture; `emit` as that of splat(). A scene without kept cells has them made for the picture.
// Bit skip_transfer_function of disable_skips: no cell is passed over.
SplatStats draw_rays(const SplatScene& scene, const SplatOptions& options, const Context& context,
                     const std::function<void(const TilePixels&)>& emit, RayCounts* counts = nullptr);

} // namespace bccsplat
