// SPDX-License-Identifier: Apache-2.0
// What is around one node of one frame, compared with the same of another frame, moved.
#pragma once

#include <vector>

#include "motion/box.h"

namespace bccsplat::motion {

// Samples up to `reach` from a place, which weigh less the further away they are.
class Block {
 public:
  Block(const Box& from, const Int3& place, int32_t reach);

  // Weighted sum of squares by which samples differ from their mean.
  [[nodiscard]] float content() const { return content_; }
  // Weighted sum of squares by which they differ from those of `to`, moved; outside, `to` has its nearest
  // sample. No more than `enough` is of interest.
  [[nodiscard]] float difference(const Box& to, const Int3& moved, float enough) const;

 private:
  Int3 first_{}, size_{};
  std::vector<float> values_, weights_;
  float content_ = 0;
};

} // namespace bccsplat::motion
