// SPDX-License-Identifier: Apache-2.0
// The loop that marks cells: a column of the plane grid along x, 16 x 16 cells across.
//
// Lanes along x are sites of a coset, two planes apart; a lane has an even and an odd cell. Stretches are 16
// lanes long, as bricks are: those without a brick in reach are left out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/aligned.h"

namespace bccsplat {

inline constexpr int column_edge = 16; // cells across
inline constexpr int stretch_lanes = 16;
// Rows of sites across a column, both cosets: from the site before its first plane on.
inline constexpr int column_sites = column_edge / 2 + 3;

// Corners are half planes apart along every axis: a lane has four, 0, 1/2, 1 and 3/2 planes from its site.
inline constexpr size_t lane_corners = 4;

// Two sites that a row of corners looks at, floats from the site of their own lane: what the first weighs for
// corners 0 and 1, the second for corners 2 and 3.
struct CornerTap {
  std::array<std::ptrdiff_t, 2> site{};
  std::array<float, lane_corners> weight{};
};

// Stencils by where a row stands between two planes of a coset; their taps are even in number.
inline constexpr size_t corner_phases = 4;
struct CornerStencils {
  std::array<std::vector<CornerTap>, corner_phases * corner_phases> all;
  [[nodiscard]] const std::vector<CornerTap>& at(int z, int y) const {
    return all[(z % 4) * corner_phases + y % 4];
  }
};

// The coefficients of a column, and their ranges over 3^3 sites of one coset.
struct ColumnSites {
  static constexpr int margin = 16; // floats before the first lane of a row
  int stretches = 0;
  std::ptrdiff_t pitch = 0; // floats from row to row
  AlignedArray<float> value, low, high;

  void set_size(int stretch_count) {
    stretches = stretch_count;
    pitch = margin + (stretches + 1) * stretch_lanes + margin;
  }
  void prepare(int stretch_count); // the same, with its memory: all coefficients are 0
  [[nodiscard]] std::ptrdiff_t at(size_t coset, int v, int w) const {
    return ((static_cast<std::ptrdiff_t>(coset) * column_sites + w) * column_sites + v) * pitch + margin;
  }
  [[nodiscard]] size_t floats() const { return 2 * column_sites * column_sites * static_cast<size_t>(pitch); }
};

struct ColumnArgs {
  ColumnSites* sites = nullptr;
  const CornerStencils* stencils = nullptr;
  float target = 0;
  float of_range = 0, of_middle = 0;  // half of CellBound's, rounding of floats included
  float site_sum = 1;                 // the largest sum of weights
  int height = 0, depth = 0;          // cells along y and z
  const uint8_t* stretches = nullptr; // those to mark, with one more that is none
  uint64_t* bits = nullptr;           // of the first block
  int blocks = 0;                     // along x
  std::ptrdiff_t row = 0, layer = 0;  // words
};
// Both run by the best target of this machine.
// Clears the stretches that cannot hold the value; set before: those with a brick in reach, and one more.
void find_stretches(const ColumnArgs& args, std::span<uint8_t> stretches);
void mark_column(const ColumnArgs& args);

} // namespace bccsplat
