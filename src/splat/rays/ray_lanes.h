// SPDX-License-Identifier: Apache-2.0
// The loops of rays, a lane a ray or a sample: which layers of cells rays pass, and between which samples
// beside each other something is to be looked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vec.h"
#include "splat/rays/surface_cells.h"

namespace bccsplat {

inline constexpr int piece_edge = 8; // pixels of a piece of a picture
inline constexpr size_t piece_rays = size_t{piece_edge} * piece_edge;

// What the parallel rays of a piece are within, sheets; enter > leave where a ray misses it.
struct PieceIntervals {
  alignas(64) std::array<double, piece_rays> enter, leave;
};
struct IntervalArgs {
  Vec3 at{}, ex{}, ey{}; // the first ray on sheet 0, and what the next pixels add
  Vec3 ez{};             // per sheet
  Vec3 begin{}, end{};   // of the box
};
// Returns a bit for each ray that meets the box: pixel (i, j) of the piece at 8 j + i.
[[nodiscard]] uint64_t find_intervals(const IntervalArgs& args, PieceIntervals& intervals);

// Blocks of a slab, and where the rays of a piece pass them: the smallest coordinates in the slab, blocks.
struct SlabArgs {
  static constexpr int parts = 8; // of a cell, that masks are for
  using Masks = std::array<uint64_t, 2 * block_edge * parts>;
  const uint64_t* bits = nullptr; // of the first block
  struct Axis {
    int blocks = 0;
    size_t stride = 0;            // words
    const Masks* masks = nullptr; // by how far a ray is from the block before it
    double first = 0, per_i = 0, per_j = 0;
  } u, v;
  std::array<uint64_t, block_edge> layer{}; // the bits of each layer of cells
};
// Writes the layers that each ray passes a bit in, and returns a bit for each ray that has any.
[[nodiscard]] uint64_t find_layers(const SlabArgs& args, std::span<uint64_t, piece_rays> layers);

// Samples along rays, in order, and behind the last one room for a vector.
struct PairArgs {
  static constexpr size_t room = 16;
  size_t count = 0;
  const float* value = nullptr;
  const std::array<float, 4>* gradient = nullptr;
  std::array<float, 3> ray{}; // of a sheet
  float target = 0;           // values on its two sides: below it or not
  float* slope = nullptr;     // of each sample, per sheet: made here
  uint64_t* found = nullptr;  // a bit for each sample
};
// Marks samples where the next one is on the other side, or the field comes closer, goes away at the next,
// and the tangents meet beyond the target.
void find_pairs(const PairArgs& args);

} // namespace bccsplat
