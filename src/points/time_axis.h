// SPDX-License-Identifier: Apache-2.0
// Time values <-> frame indices: uniform, or monotone cubic between uneven times (Fritsch & Carlson 1980).
#pragma once

#include <cstddef>
#include <vector>

namespace bccsplat {

class TimeAxis {
 public:
  TimeAxis() = default;
  // Puts frame i at first + i * step, for `count` frames; step > 0.
  TimeAxis(double first, double step, double count) : first_(first), step_(step), count_(count) {}
  // The times must rise strictly, and there must be at least one.
  explicit TimeAxis(std::vector<double> times);

  [[nodiscard]] double first() const { return times_.empty() ? first_ : times_.front(); }
  [[nodiscard]] double last() const { return times_.empty() ? first_ + (count_ - 1) * step_ : times_.back(); }
  // Both throw out_of_domain outside the series; a rounding error beyond an end counts as the end.
  [[nodiscard]] double index_of(double time) const;
  [[nodiscard]] double time_of(double index) const;
  // Returns d time / d index, of an index inside the series.
  [[nodiscard]] double slope_at(double index) const;
  // Returns whether index_of() finds one.
  [[nodiscard]] bool holds(double time) const;

 private:
  [[nodiscard]] double in_segment(size_t segment, double fraction) const;

  double first_ = 0, step_ = 1, count_ = 1;
  std::vector<double> times_, slopes_; // uneven: times and d time / d index at each frame
};

} // namespace bccsplat
