// SPDX-License-Identifier: Apache-2.0
// What each pixel of a tile gathers along its ray, as a list of samples by depth: the deep picture.
//
// A sample is a part [front, back] of the ray that absorbs evenly, with the opacity it has by itself and its
// premultiplied colour; samples of a pixel neither overlap nor are out of order ("tidy" in OpenEXR's words).
// Composited front to back they are the flat picture: each is the difference of the pixel's planes before and
// after a sheet, divided by what still passed before it.
//
// Where no pixel is ever finished (opacity_stop 1), what lies behind dense matter is there as exactly as what
// lies in front, for a host may cut the front off: the planes are taken off a pixel before so little passes
// that floats no longer tell how much, and put back in the end.
//
// Source: OpenEXR, "Interpreting OpenEXR Deep Pixels" (Hillman): a sample cut at depth x in [0, 1] absorbs
// 1 - (1 - A)^x and keeps its colour per opacity.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/paged_vector.h"
#include "base/progress.h"
#include "draw/pixel_planes.h"
#include "view/pixel_rect.h"

namespace bccsplat {

struct DeepSample {
  float front = 0, back = 0; // sheet numbers; equal: a surface
  float alpha = 0, red = 0, green = 0, blue = 0;
};

// Surfaces of a pixel that is never finished; the ray ends at the last of them.
inline constexpr uint8_t most_surfaces = 64;

// Successive segments become one sample while the picture cut at any sheet in between stays within
// `tolerance` in opacity and in colours (up to 1) of the one that keeps them apart; where pixels are never
// finished, whatever is cut off, in front as well.
class DeepTile {
 public:
  // Pixels of `pitch` per row, of which width x height belong to the tile; the planes are still clear.
  void begin_tile(int width, int height, int pitch, double tolerance, bool never_finished);
  // Takes the planes after all that lies between two sheet numbers was composited; `seen` is as
  // SheetTile::seen.
  void add_segment(const PixelPlanes& planes, float front, float back, const PixelRect& seen);
  // Takes the planes of one pixel after a surface at sheet number k. Returns whether that ends the ray: by
  // its opacity, or as the last that a ray may have.
  bool add_surface(const PixelPlanes& planes, size_t p, float k, float stop);
  // Returns whether a ray has had the last surface that it may have.
  [[nodiscard]] bool full(size_t p) const { return !fronts_.empty() && fronts_[p].surfaces == most_surfaces; }
  // Puts back what was taken off the planes, whose sums are still undivided.
  void put_fronts_back(const PixelPlanes& planes) const;
  void finish_tile(Progress& progress); // throws cancelled

  // After finish_tile these are the samples per pixel, width x height, row by row, and the samples in the
  // same order.
  [[nodiscard]] std::span<const uint32_t> counts() const { return counts_; }
  [[nodiscard]] std::span<const DeepSample> samples() const { return samples_; }

 private:
  // Red, green, blue, alpha as the planes have them.
  using Sum = std::array<float, 4>;
  struct Bounds {
    float low = 0, high = 0;
  };
  // Segments that are one sample so far.
  struct Run {
    float front = 0, back = 0;   // front = back: there is none
    Sum before{}, after{};       // of the planes
    Bounds extinction;           // per sheet step, that every cut so far allows
    std::array<Bounds, 3> color; // per opacity
  };
  // What was taken off a pixel, and the part of the light from behind that passes it.
  struct Front {
    float red = 0, green = 0, blue = 0, passes = 1;
    float depth = 0, value = 0, time = 0;
    bool any = false;
    uint8_t surfaces = 0;
  };
  struct Entry {
    uint32_t pixel;
    DeepSample sample;
  };
  [[nodiscard]] static Sum sum_of(const PixelPlanes& planes, size_t p) {
    return {planes.red[p], planes.green[p], planes.blue[p], planes.alpha[p]};
  }
  // Returns what lies between two sums, by itself.
  [[nodiscard]] static DeepSample sample_between(const Sum& before, const Sum& after, float front,
                                                 float back);
  [[nodiscard]] bool fits_run(const Run& run, const DeepSample& whole) const;
  void limit_run(Run& run, const DeepSample& whole) const;
  void start_run(Run& run, float front);
  void close_run(Run& run, size_t p);
  void take_off(const PixelPlanes& planes, size_t p);

  int width_ = 0, height_ = 0, pitch_ = 0;
  float tolerance_ = 0;
  std::vector<Run> runs_;
  std::vector<Front> fronts_; // empty: pixels are finished
  PagedVector<Entry> entries_;
  std::vector<uint32_t> counts_;
  PagedVector<DeepSample> samples_;
};

} // namespace bccsplat
