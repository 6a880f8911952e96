// SPDX-License-Identifier: Apache-2.0
// Draws lines and text into a picture that was rendered: linear colours, premultiplied, the opacity kept.
#pragma once

#include <array>
#include <string>

#include "bccsplat.h"
#include "tool/handles.h"
#include "tool/view/color_space.h"

namespace bcc4 {

// What stands out from what is behind a picture, and what sets it off from the picture itself.
struct Ink {
  Color color{1, 1, 1}, halo{0, 0, 0}; // linear
};

enum class Layer { behind, before }; // the picture: behind shows where it is transparent
enum class Anchor { left, middle, right };

using Point = std::array<double, 2>; // x and y in pixels from the top left corner

class Canvas {
 public:
  explicit Canvas(const Image& image);
  [[nodiscard]] double width() const { return plane_.width; }
  [[nodiscard]] double height() const { return plane_.height; }

  void fill(const Point& from, const Point& to, const Color& color); // whole pixels
  void line(const Point& from, const Point& to, double thickness, const Color& color, double opacity,
            Layer layer = Layer::before);
  // A line with a darker or lighter seam.
  void seamed_line(const Point& from, const Point& to, double thickness, const Color& color, const Ink& ink);
  // One line of UTF-8 whose baseline starts, has its middle or ends at a point.
  void text(const std::string& text, const Point& at, double em, Anchor anchor, const Ink& ink);

 private:
  void blend(int64_t x, int64_t y, const Color& color, double opacity, Layer layer);

  bccsplat_plane plane_;
};

} // namespace bcc4
