// SPDX-License-Identifier: Apache-2.0
// The largest value that the field takes over several instants, as one slice.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "field/coefficients/coefficients.h"
#include "field/slice.h"

namespace bccsplat {

// Takes the maximum over slices, one after the other, at the sites of their lattice, and filters it in the
// end, so that the result interpolates those maxima. The slices are time slices of one volume under one
// kernel; frame, origin and maps are the first one's.
class SiteMaxima {
 public:
  void add(const Slice& instant, const Context& context);
  [[nodiscard]] Slice finish(const Context& context); // once, after at least one slice

 private:
  std::optional<Slice> first_;
  std::array<BrickLayer, 2> largest_; // -infinity where every instant so far had a hole
  std::array<BrickLayer, 2>
      fills_; // the largest of what fills missing data, for sites that every mask so far leaves out
  std::vector<std::shared_ptr<const SliceMask>> masks_; // of all instants; null: nothing is missing
};

} // namespace bccsplat
