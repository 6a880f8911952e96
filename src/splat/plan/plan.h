// SPDX-License-Identifier: Apache-2.0
// What a picture needs before its tiles start: sheets and gaps, windows, the bricks that may be seen and the
// order in which the front reaches them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/aligned.h"
#include "base/context.h"
#include "draw/stats.h"
#include "field/lattice_sums.h"
#include "splat/loop/loops.h"
#include "splat/plan/plan_gaps.h"
#include "splat/plan/scene.h"
#include "splat/points/inside_cells.h"
#include "splat/raise/raise.h"
#include "splat/raise/raise_fan.h"

namespace bccsplat {

struct PlannedTile {
  int x = 0, y = 0, width = 0, height = 0; // pixels
  // Samples of its ring, in samples of the picture: its pixels and their border, or what those are raised
  // from.
  int ring_x = 0, ring_y = 0, ring_width = 0, ring_height = 0;
  std::vector<uint32_t> bricks;      // into SplatPlan::bricks, front to back
  std::vector<uint32_t> corrections; // into SplatPlan::corrections, that may reach its pixels or their border
  [[nodiscard]] bool empty() const { return bricks.empty() && corrections.empty(); }
};

// A brick of the slice's corrections: the sheets and pixels of the picture that it may touch.
struct PlannedCorrections {
  uint32_t brick = 0; // of SliceCorrections::add
  int64_t first_sheet = 0, last_sheet = -1;
  std::array<int, 4> rect{}; // x begin, y begin, x end, y end
};

struct PlannedBrick {
  uint32_t brick = 0; // into SplatPoints::bricks
  int64_t first_gap = 0, last_gap = 0;
  uint64_t cells = 0; // that are needed, see TransformArgs
  // Its points: the first ones of the brick in SplatPoints, or those picked from it in PickedPoints.
  uint32_t count = 0;
  bool picked = false;
  // Samples its points may touch: x begin, y begin, x end, y end; of a fan the pixels that may look at them.
  std::array<int, 4> rect{};
  BrickAxes axes;
};

// The needed points of bricks, at the places of the bricks in SplatPoints; what lies between is not set.
struct PickedPoints {
  Reservation memory;
  AlignedArray<uint16_t> position;
  AlignedArray<float> coefficient;
};

// The sheets of the picture, and how far is looked from them.
struct PlannedSheets {
  int64_t first = 0, last = -1; // that may hold samples
  int border = 0;               // pixels around a tile that gradients look at
  int lead = 0;                 // sheets on either side that gradients and isosurfaces look at
  int halfway = 0;              // of them, what values halfway between sheets are made of; 0: none are
  [[nodiscard]] bool none() const { return first > last; }
};

// How the pixels of the picture's sheets are raised from the samples of the ring's.
struct PlannedRaise {
  // Sheets are sampled at `taps` > 0: samples of their own, from which the pixels are raised; 0: pixels.
  int taps = 0;
  RaiseAxis x, y; // pixels from -border on; of a fan only the ratio, at the last sheet
  RaiseFan fan;   // perspective: then the ring's sheets are those of an orthographic view
  // The same along the sheets' normal: the sheets of the picture are raised from those of the ring; 0: they
  // are the same.
  int depth_taps = 0;
  RaiseAxis z;    // sheets from 2 * lead before the first on
  int around = 0; // a sample is of use to pixels whose own sample is at most this far away
};

struct SplatPlan {
  PlannedSheets sheets;
  PlannedRaise raise;
  PlannedRing ring;
  PlannedGaps gaps;

  // Sums of what is drawn: surfaces, maxima and analytic gradients are lit without their ripple; null: with.
  std::shared_ptr<const LatticeSums> sums;
  bool base_visible = false;
  // Orthographic composites: SheetClasses::whole.
  std::vector<std::array<float, 4>> whole_sheet;

  // Isosurfaces: samples here, beyond all of them, may lack points, and are taken for what they are known to
  // be.
  InsideCells inside;
  std::vector<PlannedBrick> bricks; // sorted by first gap
  PickedPoints picked;
  int64_t longest = 1; // gaps a brick spans at most
  std::vector<PlannedCorrections> corrections;
  std::vector<PlannedTile> tiles;
};

// Returns the scales of the picture's sheets that the points of gaps first .. last reach, of a plan with a
// fan.
[[nodiscard]] Scales gap_scales(const SplatPlan& plan, int64_t first, int64_t last);

// A tile of the picture without its bricks.
[[nodiscard]] PlannedTile plan_tile(const SplatPlan& plan, int x, int y, int width, int height);

// Points may be copied (see plan_points.h) as long as three quarters of what `copies` has left stay free;
// null: none are. with_points is false where the sheets are kept from another picture.
[[nodiscard]] SplatPlan make_plan(const SplatScene& scene, const SplatOptions& options,
                                  const Context& context, DrawStats& stats, MemoryBudget* copies = nullptr,
                                  bool with_points = true);

} // namespace bccsplat
