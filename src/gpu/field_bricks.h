// SPDX-License-Identifier: Apache-2.0
// The sites of a slice as a GPU looks them up: bricks of 16^3 of one coset with a border, so that all sites
// in reach of a point are in the brick of the nearest one. What lies beyond the lattice is there, too,
// mirrored or gone round, as far as samples outside the domain look. Bricks of zeros are not there.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

struct FieldBricks {
  int border = 1, edge = 0; // sites; edge: of a brick with its border
  Int3 first_site{};        // of the first brick, without its border, as the slice's cosets number them
  Int3 bricks{};            // per axis, of either coset
  // By coset, z, y, x: 0 where all is zero, else the number of a brick; brick 0 is zeros.
  std::vector<uint32_t> brick_at;
  std::vector<float> value; // brick after brick, x fastest
  Reservation memory;       // of them

  // Cells hold the points whose nearest site of coset 0 is one of 2^3 sites; [least, largest] of 0 and all
  // coefficients that a field in the cell depends on.
  Int3 cells{};
  std::vector<std::array<float, 2>> range;

  [[nodiscard]] size_t count() const { return value.size() / (static_cast<size_t>(edge) * edge * edge); }
  [[nodiscard]] uint64_t bytes() const { return value.size() * sizeof(float); }
  // What is on the GPU is not needed here.
  void drop_values() { value = {}, memory = {}; }
};

// border: as brick_border(). The slice's lattice is BCC. Throws memory_budget, cancelled.
[[nodiscard]] FieldBricks make_field_bricks(const Slice& slice, int border, const Context& context);

// Returns for each cell how many cells around nothing is seen of, itself included, at most 255; 0: it may be
// seen. A cell may be seen where one less than `around` cells from it is, by `seen` of its range.
template<class Seen>
[[nodiscard]] std::vector<uint8_t> unseen_cells(const FieldBricks& bricks, int around, const Seen& seen);

// The same of cells that are marked (1) where they are seen.
[[nodiscard]] std::vector<uint8_t> cells_around(const Int3& cells, int around, std::vector<uint8_t> marked);

template<class Seen>
std::vector<uint8_t> unseen_cells(const FieldBricks& bricks, int around, const Seen& seen) {
  std::vector<uint8_t> marked(bricks.range.size());
  for (size_t n = 0; n < marked.size(); ++n) marked[n] = seen(bricks.range[n][0], bricks.range[n][1]) ? 1 : 0;
  return cells_around(bricks.cells, around, std::move(marked));
}

} // namespace bccsplat
