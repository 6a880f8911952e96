// SPDX-License-Identifier: Apache-2.0
// What makes the slabs of one level of a volume that is written: a fit of the frames, or layers, and behind
// it the prefilter where coefficients are stored.
#pragma once

#include <memory>
#include <span>

#include "base/context.h"
#include "fit/fit.h"
#include "store/coefficient_slabs.h"

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
  [[nodiscard]] int level() const { return level_; }
  [[nodiscard]] Fit& fit() { return fit_; }
  [[nodiscard]] const Fit& fit() const { return fit_; }

 private:
  int level_;
  FitSink store_;
  Context context_;
  std::unique_ptr<CoefficientSlabs> coefficients_; // null: samples are stored
  Fit fit_;
};

// Returns what the file keeps of a report of a coarser level: of its samples nothing is told but how many the
// stored type could not hold.
[[nodiscard]] FitChannelReport level_counts(const FitChannelReport& report);

} // namespace bccsplat
