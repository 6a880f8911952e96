// SPDX-License-Identifier: Apache-2.0
// From the sites of a slice to one brick of the splatter: its coefficients in the order of the lattice, what
// they amount to, and its points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/points/points.h"
#include "splat/points/touched_slots.h"

namespace bccsplat {

// The coefficients of a brick's sites, 0 where there is no point: on BCC those of coset 0, then coset 1, each
// [z][y][x] of 8^3 sites; on CC the first 512.
struct BrickSites {
  static constexpr size_t count = 1024;
  alignas(64) std::array<float, count> coefficient;
};

// Reads them out of a slice; what lies beyond the planes that were folded holds no points.
class SiteReader {
 public:
  SiteReader(const Slice& slice, const FoldedSites& sites);
  // origin is the brick's first planes, counted as `sites` are and even.
  void read(const Int3& origin, BrickSites& out) const;

 private:
  struct Place { // of a plane along one axis: -1 beyond the last
    int32_t brick = -1, site = 0;
  };
  const Slice& slice_;
  std::array<std::vector<Place>, 3> places_;
};

// The points of a brick in the order they are kept: a fixed shuffle.
struct SiteOrder {
  explicit SiteOrder(bool bcc);
  bool bcc;
  std::vector<uint16_t> position; // SplatPoints::position
  std::vector<int32_t> site;      // number in BrickSites
};

// Smallest and largest coefficient of each cell of 4^3 planes, as CellRange.
struct BrickCells {
  alignas(64) std::array<float, cells_per_brick> low{}, high{};
};

// Both set count, low, high and coefficient of `brick`, and its cells: the reference loop, and the best
// target of this machine.
void summarise_reference(const BrickSites& sites, bool bcc, SplatBrick& brick, BrickCells& cells);
void summarise(const BrickSites& sites, bool bcc, SplatBrick& brick, BrickCells& cells);

// Both write the codes of its fine cells, SplatPoints::fine_cells of them.
void code_cells_reference(const BrickSites& sites, bool bcc, const SplatPoints& points, uint8_t* codes);
void code_cells(const BrickSites& sites, bool bcc, const SplatPoints& points, uint8_t* codes);

// Both write its points, `count` of them as summarised.
void list_points_reference(const BrickSites& sites, const SiteOrder& order, uint32_t count,
                           uint16_t* position, float* coefficient);
void list_points(const BrickSites& sites, const SiteOrder& order, uint32_t count, uint16_t* position,
                 float* coefficient);

} // namespace bccsplat
