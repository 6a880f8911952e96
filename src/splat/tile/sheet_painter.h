// SPDX-License-Identifier: Apache-2.0
// What the pixels of a sheet have from elsewhere: colours by another field, and what of the light comes
// through.
#pragma once

#include <cstdint>

#include "base/aligned.h"
#include "splat/plan/scene.h"
#include "splat/sheet/sheet.h"

namespace bccsplat {

// Planes of a tile's pixels that a painter of scenes lit like this one fills.
[[nodiscard]] size_t paint_planes(const SplatScene& scene);

// Sets the paint of one sheet, in planes that stay from sheet to sheet.
class SheetPainter {
 public:
  // pixels: floats of a plane.
  SheetPainter(SheetArgs& sheet, int64_t k, AlignedArray<float>& planes, size_t pixels)
      : s_(sheet), k_(static_cast<double>(k)), planes_(planes), pixels_(pixels) {}

  // Makes the colours of another scene's values, from the sheet's plane of these.
  void color(const SplatScene& paint, const float* values) const;
  // Makes the labels of a scene, which its pixels are classified by.
  void labels(const SplatScene& scene) const;
  // Makes what comes through of the scene's lights.
  void light(const SplatScene& scene) const;

 private:
  [[nodiscard]] float* plane(size_t n) const { return planes_.data() + n * pixels_; }
  // Calls body(x, y, p) for the pixels that are looked at and have something of the sheet.
  template<class Body> void each_pixel(const Body& body) const;

  SheetArgs& s_;
  double k_;
  AlignedArray<float>& planes_;
  size_t pixels_;
};

} // namespace bccsplat
