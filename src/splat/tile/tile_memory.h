// SPDX-License-Identifier: Apache-2.0
// The memory that a tile and the sheets of its objects work in, which is kept from tile to tile.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
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
// (tests/bench/notes/render-speed.md). Of several objects each one's ring and planes are fetched once for all
// of them, which saves 6 to 20 % (tests/bench/notes/trail.md). More would need more finished sheets. A power
// of two.
inline constexpr int most_sheets_at_once = 4;

// Spare floats before the first pixel of a plane: vectors may look two pixels to the left.
inline constexpr int plane_margin = 16;

// What the sheets of one object of a tile are made in.
struct SheetMemory {
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

  // Sizes the planes for a tile, and clears the plane of zeros.
  void size_planes(const SplatPlan& plan, const PlannedTile& tile);
  // The same of all, whose ring, planes and bins are cleared.
  void prepare(const SplatPlan& plan, const PlannedTile& tile, bool gradients);

  [[nodiscard]] size_t plane_floats() const {
    return plane_size(plane_pitch, height) + 2 * plane_margin + 16;
  }
  [[nodiscard]] float* ring_origin(size_t quantity) const { return ring[quantity].data() + ring_start; }
  // First pixel of the tile with its border.
  [[nodiscard]] float* plane_origin(int64_t sheet, size_t quantity) const {
    return plane[sheet][quantity].data() + plane_margin;
  }
};

struct TileMemory {
  std::vector<SheetMemory> sheets; // per object
  // Planes of the tile's pixels without its border, of pixel_pitch floats per row: what is drawn, its rays,
  // and of stills what their groups absorb and what they have from elsewhere.
  int pixel_pitch = 0;
  AlignedArray<float> pixels, rays, matter, paint;
  static constexpr size_t pixel_planes = 7;
  AlignedArray<float> mixed;  // sheets of stills
  AlignedArray<uint8_t> hole; // per pixel, for each of the sheets at once
  std::vector<SheetCrossing> crossings;
  std::vector<SurfaceHit> hits;      // where the options ask for them
  DeepTile deep;                     // where the options ask for it
  std::unique_ptr<TileMemory> apart; // of what is drawn apart, before the tile

  // Sizes the pixels for a tile, and clears them. holes: planes.
  void prepare_pixels(const PlannedTile& tile, size_t holes);
};

// Describes a tile whose pixels are done; pitch is in floats per row of its planes.
[[nodiscard]] TilePixels finished_tile(const PlannedTile& tile, int pitch, const PixelPlanes& pixel,
                                       const DeepTile* deep);

} // namespace bccsplat
