// A tile's sheets side by side: what several objects in one space absorb and give, before it is composited.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/aligned.h"
#include "splat/sheet.h"
#include "splat/splat.h"

namespace bccsplat {

// Per group (0: the slice, 1: the trail) and sheet, planes of the tile's pixels: optical depth of the slab
// along the pixel's ray, and shaded colour, value and frame index times it. Sums over the objects of a group.
class SheetStack {
 public:
  enum Quantity : size_t { red, green, blue, depth, value, time };
  static constexpr size_t quantities = 6;
  static constexpr size_t groups = 2;

  // Empties the stack for sheets first .. last and planes of `pixels` floats.
  void prepare(int64_t first, int64_t last, size_t pixels);
  [[nodiscard]] int64_t first() const { return first_; }
  [[nodiscard]] int64_t last() const { return first_ + static_cast<int64_t>(sheets_[0].size()) - 1; }
  // Null when no object of the group touched the sheet.
  [[nodiscard]] const float* plane(int64_t k, size_t group, size_t quantity) const;
  // Made and cleared at the first use of the sheet.
  [[nodiscard]] float* plane_to_add(int64_t k, size_t group, size_t quantity);

 private:
  struct Sheet {
    AlignedArray<float> planes;
    bool used = false;
  };
  int64_t first_ = 0;
  size_t pixels_ = 0;
  std::array<std::vector<Sheet>, groups> sheets_;
};

// Adds a finished sheet of one object, its extinction times `weight`.
void add_sheet(const SheetArgs& sheet, float weight, SheetStack& stack, size_t group);

enum class TrailCombine : uint8_t {
  physical = 1,              // extinctions add along the ray
  interleaved = 2,           // Neophytou & Mueller 2002, equation (8), sheet by sheet as printed
  post = 3,                  // two pictures, the slice's over the trail's
  interleaved_consistent = 4 // equation (8) made independent of the step: a = 1 - sqrt((1 - a1)(1 - a2))
};

// Front to back into `out` (planes of `pitch` floats per row, cleared before). A pixel of `surface` (may be
// null) that is covered stops the ray at its depth with its colour. combine: how the groups meet within a
// sheet; `post` is for the caller. Pixels stop at opacity `stop`.
void composite_stack(const SheetStack& stack, TrailCombine combine, const TilePixels* surface, float stop,
                     int width, int height, int pitch, const PixelPlanes& out);

} // namespace bccsplat
