// SPDX-License-Identifier: Apache-2.0
// The histogram that a survey of values is told from, and what its peaks look like.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "shade/value_survey.h"

namespace bccsplat {

// Counts over one range, with air among them and ringing in the outermost bins.
struct Histogram {
  Range range;
  std::vector<double> all, stored; // with and without the sites that are not stored
  [[nodiscard]] double width() const { return (range.high - range.low) / static_cast<double>(all.size()); }
  [[nodiscard]] double value(double bin) const { return range.low + (bin + 0.5) * width(); }
  [[nodiscard]] size_t bin(double v) const {
    return static_cast<size_t>(
        std::clamp((v - range.low) / width(), 0.0, static_cast<double>(all.size()) - 1));
  }
  [[nodiscard]] double total() const;
  // Samples in [low, high].
  [[nodiscard]] double mass(double low, double high) const;
};

// Returns bins over the values of the source, none where these have no width.
[[nodiscard]] Histogram working_histogram(const ValueCounts& counts);

// Returns a mean over 2 * reach + 1 bins, taken twice: what is left are peaks wider than combs of
// quantisation.
[[nodiscard]] std::vector<double> smoothed(const std::vector<double>& bins, int reach);

// Returns where a smoothed count falls to half the peak's, in bins from it, on the side of `step`; the number
// of bins where it does not.
[[nodiscard]] double half_width(const std::vector<double>& bins, size_t peak, int step);

// Returns the bin farthest below the line from the peak to the last bin on the side of `step` that has
// samples.
[[nodiscard]] double triangle_knee(const std::vector<double>& bins, size_t peak, int step);

// Returns the distance from 0 that half of the stored samples do not exceed.
[[nodiscard]] double median_size(const Histogram& h);

} // namespace bccsplat
