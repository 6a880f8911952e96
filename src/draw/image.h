// SPDX-License-Identifier: Apache-2.0
// Pictures: planes of float32 pixels, row 0 at the top.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/grid.h"
#include "view/pixel_rect.h"

namespace bccsplat {

// One plane, whose pixels belong to somebody else; rows do not overlap, and may go from the bottom up.
struct Plane {
  float* pixels = nullptr; // of row 0; null: the image has no such plane
  std::ptrdiff_t row_floats = 0;
  int components = 0;

  [[nodiscard]] float* at(int x, int y) const {
    return pixels + y * row_floats + plane_index(0, x, components);
  }
};

struct DeepImage; // draw/deep.h

// Hears of rectangles whose pixels are all drawn, from any thread. Those of a picture cover it without
// overlaps.
using PixelsDrawn = std::function<void(const PixelRect&)>;

struct Image {
  int width = 0, height = 0;
  Plane rgba;  // linear, premultiplied by opacity
  Plane depth; // world distance along the view direction from the camera; infinity where nothing is
  Plane value; // NaN where nothing is
  Plane time;  // frame index; NaN where nothing is
  DeepImage* deep = nullptr;          // null: not asked for
  const PixelsDrawn* drawn = nullptr; // null: nobody wants to know

  void tell_drawn(const PixelRect& pixels) const {
    if (drawn) (*drawn)(pixels);
  }
  void tell_all_drawn() const { tell_drawn({0, 0, width, height}); }
};

// An image that owns its planes.
struct ImageStorage {
  std::vector<float> rgba, depth, value, time;
  Image image;

  ImageStorage(int width, int height, bool with_depth = false, bool with_value = false,
               bool with_time = false) {
    const size_t n = plane_size(width, height);
    image.width = width, image.height = height;
    const auto plane = [&](std::vector<float>& pixels, int components) {
      pixels.resize(n * components);
      return Plane{pixels.data(), plane_offset(0, 1, width * components), components};
    };
    image.rgba = plane(rgba, 4);
    if (with_depth) image.depth = plane(depth, 1);
    if (with_value) image.value = plane(value, 1);
    if (with_time) image.time = plane(time, 1);
  }
  ImageStorage(const ImageStorage&) = delete;
  ImageStorage& operator=(const ImageStorage&) = delete;
};

} // namespace bccsplat
