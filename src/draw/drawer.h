// SPDX-License-Identifier: Apache-2.0
// The way from shots to pixels. Each drawer keeps from picture to picture what the next may need again.
#pragma once

#include <functional>

#include "base/context.h"
#include "draw/shot.h"
#include "draw/stats.h"
#include "draw/tile_pixels.h"

namespace bccsplat {

class Drawer {
 public:
  Drawer() = default;
  Drawer(const Drawer&) = delete;
  Drawer& operator=(const Drawer&) = delete;
  virtual ~Drawer() = default;

  [[nodiscard]] virtual const char* name() const = 0;
  // Returns whether it draws these into one picture.
  [[nodiscard]] virtual bool covers(Shots shots) const = 0;
  // Returns whether it needs no merged bricks of a moment of a series (field/moment.h).
  [[nodiscard]] virtual bool merges() const { return false; }
  // Makes what is kept with their slices, so that draw() finds it. Throws memory_budget, cancelled,
  // unsupported.
  virtual void prepare(Shots /*shots*/, const Context& /*context*/) {}
  // Draws; `emit` is called once per tile, from any thread. The first shot says what of the picture is asked
  // for, and its view what depths are. Throws memory_budget, cancelled.
  virtual DrawStats draw(Shots shots, const Context& context,
                         const std::function<void(const TilePixels&)>& emit) = 0;
  // Drops what was kept of earlier shots, whose slices may then go.
  virtual void forget() = 0;
};

} // namespace bccsplat
