// SPDX-License-Identifier: Apache-2.0
// Moments of a channel that follow what moves from frame to frame. The flow of an interval is found on the
// frames as the file gives them, once, and kept.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "motion/finder.h"
#include "points/time_axis.h"

namespace bccsplat::motion {

// Any thread may call. Who finds an interval takes what others found it with along, and gives it back: no
// lock is held meanwhile, and who comes then begins anew.
class MovingSeries {
 public:
  // The coefficients are of all bricks, and outlive it.
  MovingSeries(const Coefficients& coefficients, const TimeAxis& times);

  // The frames that a moment is made of beside its own layers; none at a frame, where it is that frame.
  [[nodiscard]] std::vector<size_t> frames_of(double frame) const;
  // Finds what follow() needs, if it is not known.
  void prepare(double frame, const Context& context) const;
  // Has the merged moment at a frame follow. Its samples are those along the ways where the mask is on, and
  // its coefficients are those of before, plus what makes of them what the samples have become: where no node
  // follows nothing of it is touched. Corrections of frames stay where they are, so it is done before these.
  void follow(Slice& moment, const Context& context) const;

 private:
  struct Between {
    size_t interval = 0;
    double time = 0;
  };
  template<class T> struct Held {
    std::shared_ptr<const T> what;
    Reservation memory;
  };
  struct Work {
    Finder finder;
    Reservation memory; // of what the finder holds
  };
  using Intervals = std::map<size_t, Held<Interval>>;
  using Frames = std::map<size_t, Held<Slice>>;
  // Where in the series a moment is; none at a frame, or where there is no time.
  [[nodiscard]] std::optional<Between> between(double frame) const;
  [[nodiscard]] std::shared_ptr<const Interval> interval(size_t i, const Context& context) const;
  [[nodiscard]] std::shared_ptr<const Interval> find(Work& work, size_t i, const Context& context) const;
  // A frame as a slice, and as dense samples.
  [[nodiscard]] std::shared_ptr<const Slice> frame(size_t i, const Context& context) const;
  [[nodiscard]] Box samples(size_t i, const Context& context) const;

  const Coefficients& coefficients_;
  std::vector<double> times_;
  Int3 dims_{}, step_{}; // of the samples that motion is found on, and index units between them
  mutable std::mutex mutex_;
  mutable std::unique_ptr<Work> work_; // null: somebody has it, or nobody asked
  mutable Intervals intervals_;
  mutable Frames frames_;
};

} // namespace bccsplat::motion
