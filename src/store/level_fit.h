// SPDX-License-Identifier: Apache-2.0
// What makes the slabs of a volume that is written, level by level: a fit of the frames, or layers, and
// behind it the prefilter where coefficients are stored.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "fit/fit.h"
#include "store/coefficient_slabs.h"
#include "store/level_frames.h"

namespace bccsplat {

// The options of a level: its lattice is made as that of level 0 is, of distances 2^level as large in space.
// margins: planes outside the faces of its own lattice.
[[nodiscard]] FitOptions options_of_level(FitOptions options, int level, const Int3& margins);

class LevelFit {
 public:
  // Takes the slabs as they are stored.
  using Store = std::function<void(int32_t slab, const ChannelLevel& at, const SlabLayers& layers)>;

  LevelFit(int level, const FitOptions& options, Store store, const Context& context, MaskSink masks);
  LevelFit(const LevelFit&) = delete;
  LevelFit& operator=(const LevelFit&) = delete;

  // Called before any data where coefficients are stored, for which the fit hands out layers one by one;
  // info, part: as of CoefficientSlabs.
  void store_coefficients(const VolumeInfo& info, const SeriesPart* part);
  // Ends the series with what every channel was given.
  void shorten(uint32_t frames);
  // Makes and stores what is left of a channel.
  void finish_channel(int channel);
  [[nodiscard]] Fit& fit() { return fit_; }
  [[nodiscard]] const Fit& fit() const { return fit_; }

 private:
  FitSink store_;
  Context context_;
  std::unique_ptr<CoefficientSlabs> coefficients_; // null: samples are stored
  Fit fit_;
};

// The fits of all levels of a series, none before the first data. Level 0 prepares the frames of all, and
// tells what is missing before any of them takes a frame. Coarser levels come first, so that a coarse slab is
// one read.
class LevelFits {
 public:
  // options: of all levels, level 0 first. masks: takes those of level 0.
  void begin(const std::vector<FitOptions>& options, const LevelFit::Store& store, const MaskSink& masks,
             const Context& context);
  void clear() { fits_.clear(), frames_.reset(); }
  [[nodiscard]] bool begun() const { return !fits_.empty(); }
  [[nodiscard]] int coarsest() const { return static_cast<int>(fits_.size()) - 1; }
  [[nodiscard]] LevelFit& level(int level) { return *fits_[level]; }
  [[nodiscard]] Fit& fit() { return fits_.front()->fit(); } // of level 0
  [[nodiscard]] const Fit& fit() const { return fits_.front()->fit(); }
  [[nodiscard]] const Lattice4& lattice(int level = 0) const { return fits_[level]->fit().lattice(); }

  // The next frame of a channel; scan: what the fit of level 0 found of it. ringing: of the channel there.
  void add_frame(int channel, std::span<const FrameBox> boxes, const FrameScan& scan, float ringing);
  // Puts the lattices of all levels into what a file says.
  void describe_lattices(VolumeInfo& info) const;
  // Returns the report of level 0, with the channels of coarser levels behind its own: of their samples the
  // file tells nothing but how many the stored type could not hold.
  [[nodiscard]] FitReport report() const;

 private:
  std::vector<std::unique_ptr<LevelFit>> fits_; // by level
  std::optional<LevelFrames> frames_;
};

} // namespace bccsplat
