// SPDX-License-Identifier: Apache-2.0
// Draws shots by sheets: every mode, any slice, with a trail or without, alone or beside others.
#pragma once

#include "draw/drawer.h"
#include "splat/tile/kept_sheets.h"

namespace bccsplat {

class SheetDrawer : public Drawer {
 public:
  [[nodiscard]] const char* name() const override { return "sheets"; }
  [[nodiscard]] bool covers(Shots /*shots*/) const override { return true; }
  void prepare(Shots shots, const Context& context) override;
  DrawStats draw(Shots shots, const Context& context,
                 const std::function<void(const TilePixels&)>& emit) override;
  void forget() override { kept_.forget(); }

 private:
  KeptSheets kept_; // of shots whose points are kept
};

} // namespace bccsplat
