// SPDX-License-Identifier: Apache-2.0
// The layers near the ends of a series: frames beyond an end are replaced by predictions from those next to
// it (ends.h), no bolder than the series itself bears out.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "fit/axis/filter.h"
#include "fit/beyond/ends.h"
#include "fit/beyond/noise_trial.h"
#include "fit/kept/site_block.h"
#include "lattice/lattice.h"

namespace bccsplat {

// The filter in time for one layer, a table of one position; on D4* the outermost of two layers outside an
// end makes up for the mirrors behind it (against_mirrors.h). end_known: the lattice ends where the series
// does.
[[nodiscard]] FilterTable layer_table(const Lattice4& lattice, int32_t layer, bool end_known,
                                      double widening);

// Returns which of the end_noises predicts a frame best of those behind it, at some of the sites. frames:
// from the end inwards.
[[nodiscard]] uint8_t choose_end_level(const std::vector<const FrameSites*>& frames, const Lattice3& lattice,
                                       double widening);

// Numbers of end_noises for the first and the last end of the series of one channel, each chosen when a layer
// needs it.
using EndLevels = std::array<std::optional<uint8_t>, 2>;

// Predictions for the ends of a series: where two layers stand outside each of all end_noises, else, as older
// files have them, of one noise for all.
class EndPredictions {
 public:
  EndPredictions(double widening, int32_t lead);

  // Returns how many noises there are to choose among.
  [[nodiscard]] size_t levels() const { return of_level_.size(); }
  // Frames next to an end that predictions look at, when there are as many.
  [[nodiscard]] int64_t used() const { return of_level_[0].used(); }
  // The frames of a series of n that a table of one position takes, and their weights. level: of the first
  // or the last end, below levels().
  [[nodiscard]] std::vector<std::pair<int64_t, float>> inside(const FilterTable& table, int64_t n,
                                                              const std::function<uint8_t(bool last)>& level);

 private:
  std::vector<EndFrames> of_level_;
};

} // namespace bccsplat
