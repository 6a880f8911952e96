// SPDX-License-Identifier: Apache-2.0
// The memory that a tile works in, which is kept from tile to tile.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/aligned.h"
#include "base/grid.h"
#include "draw/tile_pixels.h"
#include "splat/loop/loops.h"
#include "splat/plan/plan.h"
#include "splat/sheet/sheet.h"
#include "splat/tile/finished_sheets.h"

namespace bccsplat {

// Pixels are read and written once for all sheets composited together: 3 to 5 % less time than one by one
// (tests/bench/notes/render-speed.md). More would need more finished sheets.
inline constexpr int most_sheets_at_once = 4;

// Spare floats before the first pixel of a plane: vectors may look two pixels to the left.
inline constexpr int plane_margin = 16;

struct TileMemory {
  // Sizes of the tile at hand.
  int width = 0, height = 0;           // pixels of its planes, with their border
  int ring_width = 0, ring_height = 0; // samples of its ring
  int ring_pitch = 0;                  // samples
  size_t group_floats = 0;
  size_t ring_start = 0; // floats before the ring's first sample
  int plane_pitch = 0;   // floats

  std::array<AlignedArray<float>, 4> ring;
  FinishedSheets<std::array<AlignedArray<float>, 4>> plane; // value, di, dj, dk
  AlignedArray<float> zero_plane;
  // Samples that pixels are raised from, rows of sample_pitch floats, and room for the raising.
  int sample_pitch = 0; // floats
  AlignedArray<float> samples, scratch;
  RaiseAxis fan_x, fan_y; // of the sheet at hand
  static_assert(most_taps <= finished_sheets);
  FinishedSheets<AlignedArray<float>> stack; // the ring's sheets that sheets are raised from

  // Pixels of the tile without its border, planes of pixel_pitch floats per row.
  int pixel_pitch = 0;
  AlignedArray<float> pixels;
  static constexpr size_t pixel_planes = 13;
  AlignedArray<uint8_t> hole; // per pixel, for each of the sheets at once
  std::vector<SheetCrossing> crossings;
  std::vector<SurfaceHit> hits; // where the options ask for them
  DeepTile deep;                // where the options ask for it

  // Points that wait for their gap, in the bin of its number modulo the count of bins, a power of two. One
  // more bin takes what is rejected.
  std::vector<AlignedArray<SplatRecord>> bins;
  std::vector<SplatRecord*> bin_end;
  [[nodiscard]] uint32_t bin_mask() const { return static_cast<uint32_t>(bins.size() - 2); }
  // Makes room for `count` more points in a bin.
  void make_room(size_t bin, size_t count) {
    const size_t used = bin_end[bin] - bins[bin].data();
    if (used + count <= bins[bin].capacity()) return;
    bins[bin].grow(used + count, used);
    bin_end[bin] = bins[bin].data() + used;
  }

  // Sizes everything for a tile and clears the ring, the pixels and the bins.
  void prepare(const SplatPlan& plan, const PlannedTile& tile, bool gradients);
  // These are its parts: the planes' sizes and the plane of zeros; ring, planes and bins; the pixels.
  void size_planes(const SplatPlan& plan, const PlannedTile& tile);
  void prepare_sheets(const SplatPlan& plan, const PlannedTile& tile, bool gradients);
  void prepare_pixels(int tile_width, int tile_height);

  [[nodiscard]] size_t plane_floats() const {
    return plane_size(plane_pitch, height) + 2 * plane_margin + 16;
  }
  [[nodiscard]] float* ring_origin(size_t quantity) const { return ring[quantity].data() + ring_start; }
  // First pixel of the tile with its border.
  [[nodiscard]] float* plane_origin(int64_t sheet, size_t quantity) const {
    return plane[sheet][quantity].data() + plane_margin;
  }
  [[nodiscard]] float* pixel_plane(size_t n, int tile_height) const {
    return pixels.data() + n * plane_size(pixel_pitch, tile_height);
  }
  [[nodiscard]] uint8_t* hole_plane(size_t n, int tile_height) {
    return hole.data() + n * plane_size(pixel_pitch, tile_height);
  }
};

// Describes a tile whose pixels are done; pitch is in floats per row of its planes.
[[nodiscard]] TilePixels finished_tile(const PlannedTile& tile, int pitch, const PixelPlanes& pixel,
                                       const DeepTile* deep);

} // namespace bccsplat
