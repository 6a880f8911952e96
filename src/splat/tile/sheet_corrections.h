// SPDX-License-Identifier: Apache-2.0
// Adds the corrections of a slice to the sheets of a tile: those near a sheet become small bumps on it.
#pragma once

#include <cstdint>

#include "splat/plan/plan_corrections.h"
#include "view/pixel_rect.h"

namespace bccsplat {

// The pixels of a plane, which starts at pixel (x, y) of the picture.
struct PlanePixels {
  float* first = nullptr;
  int pitch = 0; // floats
  int x = 0, y = 0, width = 0, height = 0;
};

class SheetCorrections {
 public:
  // Everything passed must outlive it, and the slice must have corrections.
  SheetCorrections(const SplatScene& scene, const SplatPlan& plan, const PlannedTile& tile);

  // Returns whether any correction may reach sheet k.
  [[nodiscard]] bool reach(int64_t k) const;
  // Adds those that reach sheet k; returns the pixels, counted from the plane's first, that have changed. A
  // pixel gets the same sum whatever plane it is in.
  PixelRect add(int64_t k, const PlanePixels& plane) const;

 private:
  struct Sheet;
  void add_point(const Sheet& sheet, const Int3& at, float value, const PlanePixels& plane,
                 PixelRect& changed) const;

  const SplatScene& scene_;
  const SplatPlan& plan_;
  const PlannedTile& tile_;
  CorrectionView at_;
  FallOff fall_;
};

} // namespace bccsplat
