// SPDX-License-Identifier: Apache-2.0
// The sites of a slice as a GPU looks them up: bricks of 16^3 of one coset with a border, so that all sites
// in reach of a point are in the brick of the nearest one. What lies beyond the lattice is there, too,
// mirrored or gone round, as far as samples outside the domain look. Bricks of zeros are not there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "field/slice.h"
#include "gpu/field_marks.h"

namespace bccsplat {

struct FieldBricks {
  int border = 1, edge = 0; // sites; edge: of a brick with its border
  Int3 first_site{};        // of the first brick, without its border, as the slice's cosets number them
  Int3 bricks{};            // per axis, of either coset
  // By coset, z, y, x: 0 where all is zero, else the number of a brick; brick 0 is zeros.
  std::vector<uint32_t> brick_at;
  std::vector<float> value; // brick after brick, x fastest
  FieldFixes fixes;
  MissingSamples missing;
  // Which sites are holes, from the first brick's first one on, the second coset behind the first; empty:
  // none.
  BitBox holes;
  Reservation memory; // of all that

  // Cells hold the points whose nearest site of coset 0 is one of 2^3 sites; bounds of the field in the cell,
  // relative to its base, and 0.
  Int3 cells{};
  std::vector<std::array<float, 2>> range;

  [[nodiscard]] int cosets() const {
    return static_cast<int>(brick_at.size() / (static_cast<size_t>(bricks[0]) * bricks[1] * bricks[2]));
  }
  [[nodiscard]] size_t count() const { return value.size() / (static_cast<size_t>(edge) * edge * edge); }
  [[nodiscard]] uint64_t site_bytes() const { return value.size() * sizeof(float); }
  // What all of it takes on the GPU.
  [[nodiscard]] uint64_t bytes() const {
    return site_bytes() + fixes.value.size() * sizeof(float) +
           (missing.bits.words.size() + holes.words.size()) * sizeof(uint32_t);
  }
  // What is on the GPU is not needed here.
  void drop_values() { value = {}, fixes.value = {}, missing.bits.words = {}, holes.words = {}, memory = {}; }
};

// The same of one layer of one coset: its bricks, and the ranges of its coefficients alone by cell.
struct LayerBricks {
  std::vector<uint32_t> brick_at;
  std::vector<float> value;
  std::vector<std::array<float, 2>> range;
  Reservation memory;
  void drop_values() { value = {}, memory = {}; }
};

// like: bricks of a slice of the lattice. Throws memory_budget, cancelled.
[[nodiscard]] LayerBricks make_layer_bricks(const BrickLayer& layer, const FieldBricks& like,
                                            const Context& context);

// A layer that moments are merged of, and its coset.
struct MomentLayer {
  size_t coset = 0;
  const LayerBricks* layer = nullptr;
};
// Returns the bricks, without values, that all moments between these layers have, and bounds of their fields.
// most: the most that the weights of a coset add up to. The slice misses nothing; its corrections are there,
// with their values.
[[nodiscard]] FieldBricks moment_bricks(const Slice& slice, int border, std::span<const MomentLayer> layers,
                                        float most);
// Where bricks stand of such a slice; none is there.
[[nodiscard]] FieldBricks no_bricks(const Slice& slice, int border);

// border: as brick_border(). Throws memory_budget, cancelled.
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
