// SPDX-License-Identifier: Apache-2.0
// A moment on the lattice, where its interval's mask is on, along the ways of things.
#pragma once

#include <memory>
#include <vector>

#include "base/context.h"
#include "field/slice.h"
#include "motion/finder.h"

namespace bccsplat::motion {

// A frame of the sum, and its share (shares.h).
struct MovedFrame {
  std::shared_ptr<const Slice> slice; // on the lattice of the moment
  float weight = 0, ahead = 0;
};

struct MovedSum {
  const Interval& interval;
  std::vector<MovedFrame> frames;
  float halfway = 0;  // how far the moment is before the middle of the interval, in its length
  Int3 step{1, 1, 1}; // index units from one sample that the flow was found on to the next
};

// Adds to a moment what it lacks of the sum. Bricks without a node that follows are not looked at, and but
// for those beside others they stay the same objects.
void follow_ways(Slice& moment, const MovedSum& sum, const Context& context);

} // namespace bccsplat::motion
