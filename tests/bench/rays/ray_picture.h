// SPDX-License-Identifier: Apache-2.0
// An opaque isosurface, orthographic and shaded, by rays on one thread: without points and sheets.
#pragma once

#include <cstdint>
#include <memory>

#include "render/picture.h"
#include "tests/bench/rays/ray_blocks.h"

namespace bccsplat::bench {

struct RayCounts {
  uint64_t samples = 0, hits = 0, searches = 0, grazes = 0;
};

class RayPicture {
 public:
  // The scene's slice is on BCC, without corrections, holes and clips; the ranges are of it. everywhere: no
  // cell is passed over. Scene and ranges must outlive it.
  RayPicture(const Scene& scene, const CellRanges& ranges, double iso_value, bool everywhere = false);

  // step: between samples along a ray, T. keep_bits: of the last picture, whose axis is the same.
  void draw(double step, bool keep_bits, Image& image);

  [[nodiscard]] const RayCounts& counts() const { return counts_; } // of the last picture

 private:
  const Scene& scene_;
  const CellRanges& ranges_;
  double iso_value_;
  bool everywhere_;
  std::shared_ptr<const LatticeSums> sums_;
  BlockBits bits_;
  RayCounts counts_;
};

} // namespace bccsplat::bench
