// SPDX-License-Identifier: Apache-2.0
// Regions of a frame that reach beyond its ends along periodic axes, where its samples come once more.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "lattice/lattice.h"

namespace bccsplat {

// A part of such a region: the samples it stands for, and how far on in the region they are.
struct RegionPiece {
  Region samples;
  std::array<int64_t, 3> shift{};
};

// The pieces of a region of a frame of n samples; beyond the ends of axes that do not turn it has none.
[[nodiscard]] std::vector<RegionPiece> region_pieces(const Region& region, const std::array<int64_t, 3>& n,
                                                     const AxisFlags& turning);

// Returns what CellRanges::range does of a turned region.
[[nodiscard]] CellRanges::Cell turned_range(const CellRanges& cells, const Region& region,
                                            const std::array<int64_t, 3>& n, const AxisFlags& turning);

// Reads the samples of a region.
class TurnedFrame {
 public:
  // frame: outlives it.
  TurnedFrame(const Frame& frame, const Region& region, const AxisFlags& turning);
  [[nodiscard]] size_t boxes() const; // that it is read from
  // Reads a part of the region as Frame::read does.
  void read(const Region& part, float* out, int64_t row, int64_t plane) const;

 private:
  const Frame& frame_;
  std::vector<RegionPiece> pieces_;
  std::vector<std::vector<uint32_t>> boxes_; // of each piece
};

} // namespace bccsplat
