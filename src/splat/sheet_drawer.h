// SPDX-License-Identifier: Apache-2.0
// Draws shots by sheets: every mode, any slice, with a trail or without.
#pragma once

#include <span>

#include "draw/drawer.h"
#include "splat/tile/kept_sheets.h"

namespace bccsplat {

class SheetDrawer : public Drawer {
 public:
  [[nodiscard]] const char* name() const override { return "sheets"; }
  [[nodiscard]] bool covers(const Shot& /*shot*/) const override { return true; }
  void prepare(const Shot& shot, const Context& context) override;
  DrawStats draw(const Shot& shot, const Context& context,
                 const std::function<void(const TilePixels&)>& emit) override;
  void forget() override { kept_.forget(); }

 private:
  KeptSheets kept_; // of shots whose points are kept
};

// Draws several shots of mode composite into one picture; their views have the same pixels and sheets. `emit`
// is as Drawer's.
DrawStats draw_sheets_together(std::span<const Shot* const> shots, const Context& context,
                               const std::function<void(const TilePixels&)>& emit);

} // namespace bccsplat
