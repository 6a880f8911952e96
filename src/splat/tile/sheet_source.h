// SPDX-License-Identifier: Apache-2.0
// The sheets of one set of points in one tile, front to back: bricks are moved to the screen when the front
// reaches them, their points splatted into the ring gap by gap, finished sheets taken out of it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "draw/stage_clock.h"
#include "splat/tile/kept_sheets.h"
#include "splat/tile/open_pixels.h"
#include "splat/tile/sheet_corrections.h"
#include "splat/tile/tile_memory.h"
#include "view/pixel_rect.h"

namespace bccsplat {

// Sets to zero what is inside `before` and outside of `now`.
void clear_around(const PixelRect& before, const PixelRect& now, float* plane, int pitch);

struct SheetSourceArgs {
  const SplatScene* scene = nullptr;
  const SplatPlan* plan = nullptr;
  const KernelPolynomial* kernel = nullptr;
  bool reference_loops = false;
  bool gradients = false;   // the sums of the analytic gradient, too
  KeptTile* kept = nullptr; // not with use draw
  KeptSheets::Use use = KeptSheets::Use::draw;
};

class SheetSource {
 public:
  // Everything passed must outlive the source. `memory` is prepared when the first point comes.
  SheetSource(const SheetSourceArgs& args, const PlannedTile& tile, SheetMemory& memory, DrawStats& stats);

  // Says which sheets will be asked for; none outside of them may be.
  void begin_sheets(int64_t first_sheet, int64_t last_sheet);
  // Completes the sheets up to k, which rises from call to call. What `open` hides is left out; null:
  // everything is open. `clock` is that of the stage under way.
  void complete_sheets(int64_t k, const OpenPixels* open, StageClock::time_point& clock);

  // Counts the visits of the tile to bricks: no sheet is asked for any more.
  void end_sheets();

  // These two ask for one of the last finished_sheets completed sheets: whether anything is on it, and its
  // plane, which starts at the tile's first pixel and reaches plan.sheets.border beyond the tile. Quantity 0
  // is the value relative to the base; 1, 2 and 3 are the sums of the gradient.
  [[nodiscard]] bool filled(int64_t k) const { return filled_[k]; }
  [[nodiscard]] const float* plane(int64_t k, size_t quantity) const;
  // Returns the pixels of the tile outside of which such a sheet is empty.
  [[nodiscard]] PixelRect touched(int64_t k) const;
  // Returns the same for its whole plane, border included, in whole vectors, counted from the plane's first
  // float.
  [[nodiscard]] PixelRect plane_touched(int64_t k) const;
  [[nodiscard]] const float* zero_plane() const; // as the plane of an empty sheet
  [[nodiscard]] int plane_pitch() const { return pitch_; }
  [[nodiscard]] size_t plane_floats() const { return m_.plane_floats(); }

 private:
  void prepare_sheets();
  void prepare_fan();
  void splat_gap(int64_t s, const OpenPixels* open, StageClock::time_point& clock);
  void activate_brick(uint32_t planned, const OpenPixels* open);
  size_t drop_hidden_points(int64_t s, SplatRecord* records, size_t count, const OpenPixels& open);
  void splat_bin(int64_t s, const SplatRecord* records, size_t count);
  void mark_touched_samples(int64_t s, const SplatRecord* records, size_t count);
  void extract_sheet(int64_t k);
  void extract_plane(int64_t k, size_t quantity, float* plane, int pitch, PixelRect& holds);
  void keep_plane(int64_t k, size_t quantity, const float* plane, int pitch, const PixelRect& rect);
  void take_kept_sheet(int64_t k);
  void blend_sheet(int64_t k);
  void raise_sheet(int64_t k, const PixelRect& touched);
  // The sheets that may be raised: those that rays inside the slice look at. Others are empty, where objects
  // that reach further are drawn beside this one.
  [[nodiscard]] int64_t first_raised() const { return plan_.sheets.first - 2 * plan_.sheets.lead; }
  [[nodiscard]] int64_t last_raised() const { return plan_.sheets.last + 2 * plan_.sheets.lead; }
  [[nodiscard]] bool raised(int64_t k) const { return k >= first_raised() && k <= last_raised(); }
  [[nodiscard]] static PixelRect whole_vectors(const PixelRect& r);
  [[nodiscard]] PixelRect raised_pixels(const PixelRect& touched) const;
  [[nodiscard]] size_t slot(int64_t k) const {
    return ((k % plan_.ring.sheets) + plan_.ring.sheets) % plan_.ring.sheets;
  }
  void normalise_sheet(int64_t k);
  void correct_sheet(int64_t k);
  void scatter_sheet(int64_t k);
  [[nodiscard]] size_t bin_of(int64_t gap) const {
    return static_cast<size_t>(gap - plan_.gaps.first) & m_.bin_mask();
  }

  const SplatScene& scene_;
  const SplatPlan& plan_;
  const KernelPolynomial& kernel_;
  const SplatLoops& loops_;
  const PlannedTile& tile_;
  SheetMemory& m_;
  DrawStats& stats_;
  size_t quantities_ = 1;
  KeptTile* kept_;
  KeptSheets::Use use_;
  int pitch_ = 0;
  bool prepared_ = false;
  size_t next_brick_ = 0;
  int64_t first_gap_ = 0, last_gap_ = -1, next_gap_ = 0;
  int64_t last_filled_ = INT64_MIN;             // sheet
  std::optional<SheetCorrections> corrections_; // of tiles that have some
  FinishedSheets<bool> filled_;
  // The samples that points touch on the sheets under way, by slot of the ring.
  std::vector<PixelRect> ring_touched_;
  // The pixels outside of which planes are zero, and the samples outside of which `samples` are; in whole
  // vectors.
  FinishedSheets<PixelRect> plane_touched_;
  PixelRect samples_held_{0, 0, 0, 0};
  // The rectangle of each gap, where sheets are raised by a fan, as FanArgs has it.
  std::vector<std::array<int32_t, 4>> gap_rect_;
  std::vector<float> inverse_near_, inverse_far_;
  FanArgs fan_;
  // The next sheet to be made, where sheets are raised along their normal or points are scattered. The ring's
  // sheets that others are raised from: whether anything is on them, where it is, and outside of what their
  // planes are zero.
  int64_t next_sheet_ = 0;
  FinishedSheets<bool> stack_filled_;
  FinishedSheets<PixelRect> stack_touched_, stack_held_;
};

} // namespace bccsplat
