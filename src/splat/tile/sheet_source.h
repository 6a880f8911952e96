// The sheets of one set of points in one tile, front to back: bricks are moved to the screen when the front
// reaches them, their points splatted into the ring slab by slab, finished sheets taken out of it.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "splat/tile/kept_sheets.h"
#include "splat/tile/open_pixels.h"
#include "splat/tile/tile_memory.h"
#include "splat/view/pixel_rect.h"

namespace bccsplat {

// Adds the time since `from`, ms, to `sum` and starts the next stage.
using StageClock = std::chrono::steady_clock;
void lap(StageClock::time_point& from, double& sum);

// Sets to zero what is inside `before` and outside of `now`.
void clear_around(const PixelRect& before, const PixelRect& now, float* plane, int pitch);

struct SheetSourceArgs {
  const SplatScene* scene = nullptr;
  const SplatPlan* plan = nullptr;
  const KernelPolynomial* kernel = nullptr;
  bool scalar = false;
  bool gradients = false;   // the sums of the analytic gradient, too
  KeptTile* kept = nullptr; // not with use draw
  KeptSheets::Use use = KeptSheets::Use::draw;
};

class SheetSource {
 public:
  // Everything outlives the source. `memory` is prepared when the first point comes.
  SheetSource(const SheetSourceArgs& args, const PlannedTile& tile, TileMemory& memory, SplatStats& stats);

  // The sheets that will be asked for; none outside of them are.
  void begin(int64_t first_sheet, int64_t last_sheet);
  // Completes the sheets up to k; k rises. What `open` (null: everything is open) hides is left out. clock:
  // of the stage under way.
  void complete(int64_t k, const OpenPixels* open, StageClock::time_point& clock);

  static constexpr int kept_sheets = 8;
  // Of one of the last kept_sheets completed sheets: whether anything is on it, and its plane, which starts
  // at the tile's first pixel and reaches plan.border beyond it; quantity 0: value relative to air, 1 .. 3:
  // sums of the gradient.
  [[nodiscard]] bool filled(int64_t k) const { return filled_[static_cast<size_t>(k & 7)]; }
  [[nodiscard]] const float* plane(int64_t k, size_t quantity) const;
  // Of such a sheet: the pixels of the tile outside of which it is empty.
  [[nodiscard]] PixelRect touched(int64_t k) const;
  // The same of its whole plane, border included, in whole vectors, counted from the plane's first float.
  [[nodiscard]] PixelRect plane_touched(int64_t k) const;
  [[nodiscard]] const float* zero() const; // as the plane of an empty sheet
  [[nodiscard]] int plane_pitch() const { return pitch_; }
  [[nodiscard]] size_t plane_floats() const { return m_.plane_floats(); }

 private:
  void prepare();
  void prepare_fan();
  void slab(int64_t s, const OpenPixels* open, StageClock::time_point& clock);
  void activate(uint32_t planned, const OpenPixels* open);
  size_t drop_hidden(int64_t s, SplatRecord* records, size_t count, const OpenPixels& open);
  void splat_bin(int64_t s, const SplatRecord* records, size_t count);
  void touch(int64_t s, const SplatRecord* records, size_t count);
  void extract(int64_t k);
  void take_out(int64_t k, size_t quantity, float* plane, int pitch, PixelRect& holds);
  void keep(int64_t k, size_t quantity, const float* plane, int pitch, const PixelRect& rect);
  void take_kept(int64_t k);
  void raise_depth(int64_t k);
  void raise_sheet(int64_t k, const PixelRect& touched);
  [[nodiscard]] static PixelRect widened(const PixelRect& r); // to whole vectors
  [[nodiscard]] PixelRect raised(const PixelRect& touched) const;
  [[nodiscard]] size_t slot(int64_t k) const {
    return static_cast<size_t>(((k % plan_.sheets) + plan_.sheets) % plan_.sheets);
  }
  void normalise(int64_t k);
  [[nodiscard]] size_t bin_of(int64_t slab) const {
    return static_cast<size_t>(slab - plan_.first_slab) & m_.bin_mask();
  }

  const SplatScene& scene_;
  const SplatPlan& plan_;
  const KernelPolynomial& kernel_;
  const SplatKernels& kernels_;
  const PlannedTile& tile_;
  TileMemory& m_;
  SplatStats& stats_;
  size_t quantities_ = 1;
  KeptTile* kept_;
  KeptSheets::Use use_;
  int pitch_ = 0;
  bool prepared_ = false;
  size_t next_brick_ = 0;
  int64_t first_slab_ = 0, last_slab_ = -1, next_slab_ = 0;
  int64_t last_filled_ = INT64_MIN;        // sheet
  std::array<bool, kept_sheets> filled_{}; // by sheet & 7
  // Samples of the ring: what points touch of the sheets under way, by slot.
  std::vector<PixelRect> ring_touched_;
  // Pixels outside of which the planes are zero, by sheet & 7, and such samples; in whole vectors.
  std::array<PixelRect, kept_sheets> plane_touched_{};
  PixelRect samples_held_{0, 0, 0, 0};
  // Where sheets are raised by a fan: of each slab.
  std::vector<std::array<int32_t, 4>> slab_rect_;
  std::vector<float> inverse_near_, inverse_far_;
  FanArgs fan_;
  // Where sheets are raised along their normal: the next one, and of the ring's sheets, by sheet & 7, whether
  // anything is on them, where, and outside of what their planes are zero.
  int64_t next_sheet_ = 0;
  std::array<bool, most_taps> stack_filled_{};
  std::array<PixelRect, most_taps> stack_touched_{}, stack_held_{};
};

} // namespace bccsplat
