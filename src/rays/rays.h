// SPDX-License-Identifier: Apache-2.0
// An opaque isosurface without points and sheets: rays sample the field at whole sheets,
// in cells that may hold the value, and find roots and turning points as sheets have them.
//
// Which cells these are is proven (cell_bound.h), so that no pixel differs from a search of all of them.
// tests/bench/notes/isosurfaces.md has the measurements.
#pragma once

#include <functional>

#include "base/context.h"
#include "draw/drawer.h"
#include "rays/ray_search.h"
#include "rays/surface_cells.h"

namespace bccsplat {

// Returns whether rays draw a picture of this slice in this view: a time slice on BCC by a kernel with a
// bound, all of whose domain has a field without holes, masks, corrections, clips and periodic axes; a view
// that is not too wide for its pixels (find_ray_axes()), one opaque surface, not deep.
[[nodiscard]] bool rays_cover(const Slice& slice, const SheetView& view, const ShotOptions& options);

// Draws such a shot; `emit` as that of Drawer. cells: of earlier pictures; null: they are made for this one.
// Bit skip_transfer_function of disable_skips: no cell is passed over.
DrawStats draw_rays(const Shot& shot, const Context& context,
                    const std::function<void(const TilePixels&)>& emit, KeptSurfaceCells* cells = nullptr,
                    RayCounts* counts = nullptr);

// Rays as a drawer, which keeps the cells of surfaces from picture to picture.
class RayDrawer : public Drawer {
 public:
  [[nodiscard]] const char* name() const override { return "rays"; }
  [[nodiscard]] bool covers(Shots shots) const override {
    const Shot& shot = *shots.front();
    return shots.size() == 1 && !shot.trail && !shot.paint &&
           rays_cover(*shot.slice, *shot.view, shot.options);
  }
  DrawStats draw(Shots shots, const Context& context,
                 const std::function<void(const TilePixels&)>& emit) override {
    return draw_rays(*shots.front(), context, emit, &cells_);
  }
  void forget() override { cells_.forget(); }
  [[nodiscard]] KeptSurfaceCells& cells() { return cells_; }

 private:
  KeptSurfaceCells cells_;
};

} // namespace bccsplat
