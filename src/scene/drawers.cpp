// SPDX-License-Identifier: Apache-2.0
// The one file that knows which drawers there are.
#include "scene/drawers.h"

#include <algorithm>
#include <utility>

#include "rays/rays.h"
#include "splat/sheet_drawer.h"

namespace bccsplat {

Drawers::Drawers() {
  auto rays = std::make_unique<RayDrawer>();
  rays_ = rays.get();
  drawers_.push_back(std::move(rays));
  drawers_.push_back(std::make_unique<SheetDrawer>());
}

Drawer& Drawers::drawer_of(const Shot& shot, bool sheets_only) {
  if (sheets_only) return *drawers_.back();
  return **std::find_if(drawers_.begin(), drawers_.end() - 1,
                        [&](const auto& drawer) { return drawer->covers(shot); });
}

KeptSurfaceCells& Drawers::surface_cells() { return rays_->cells(); }

void Drawers::forget() {
  for (const auto& drawer : drawers_) drawer->forget();
}

DrawStats draw_together(std::span<const Shot* const> shots, const Context& context,
                        const std::function<void(const TilePixels&)>& emit) {
  return draw_sheets_together(shots, context, emit);
}

} // namespace bccsplat
