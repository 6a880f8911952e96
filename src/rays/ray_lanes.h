// SPDX-License-Identifier: Apache-2.0
// The loops of rays, a lane a ray or a sample: which layers of cells rays pass, and between which samples
// beside each other something is to be looked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vec.h"
#include "rays/surface_cells.h"

namespace bccsplat {

inline constexpr int piece_edge = 8; // pixels of a piece of a picture
inline constexpr size_t piece_rays = size_t{piece_edge} * piece_edge;

// The rays of a piece, pixel (i, j) of it at 8 j + i. They run along axis w of u, v, w.
struct PieceRays {
  using Doubles = std::array<double, piece_rays>;
  alignas(64) Doubles enter, leave; // sheets that a ray is in the box between; enter > leave: it misses it
  alignas(64) Doubles first, per_plane; // the sheet at w = 0, and sheets from plane to plane
  struct Across {
    // Blocks per block of w, and the smallest coordinate in the slab from w = 0 on, blocks.
    alignas(64) Doubles slope, low;
  } u, v;
};
struct PieceArgs {
  Vec3 at{}, at_i{}, at_j{};    // the first ray on sheet 0, and what the next pixels add, lattice units
  Vec3 ray{}, ray_i{}, ray_j{}; // the same of a sheet
  double front = 0;             // the sheet number that rays begin at
  Vec3 begin{}, end{};          // of the box
  std::array<size_t, 3> axes{}; // u, v, w
  double plane = 1;             // lattice units
};
// Returns a bit for each ray that meets the box. No ray is perpendicular to w.
[[nodiscard]] uint64_t find_rays(const PieceArgs& args, PieceRays& rays);

// Which cells of a block rays with about the same slope may pass along u or v, by their smallest coordinate
// in the slab, in eighths of a cell from across - 1 blocks before the block on.
struct PassMasks {
  static constexpr int parts = 8; // of a cell
  static constexpr size_t places = block_edge * parts;
  static constexpr int most_across = 4;
  int across = 2; // blocks that a ray may pass
  std::array<uint64_t, most_across * places> words{};
};

// Blocks of a slab.
struct SlabArgs {
  const uint64_t* bits = nullptr; // of the first block
  int place = 0;                  // of the slab along w
  struct Axis {
    int begin = 0, end = 0; // blocks that are looked at
    size_t stride = 0;      // words
    const PassMasks* masks = nullptr;
  } u, v;
  std::array<uint64_t, block_edge> layer{}; // the bits of each layer of cells
};
// Writes the layers that each ray passes a bit in, and returns a bit for each ray that has any.
[[nodiscard]] uint64_t find_layers(const SlabArgs& args, const PieceRays& rays,
                                   std::span<uint64_t, piece_rays> layers);

// Samples along rays, in order, and behind the last one room for a vector.
struct PairArgs {
  static constexpr size_t room = 16;
  size_t count = 0;
  const float* value = nullptr;
  const std::array<float, 4>* gradient = nullptr;
  const std::array<float, 4>* ray = nullptr; // of a sheet
  float target = 0;                          // values on its two sides: below it or not
  float* slope = nullptr;                    // of each sample, per sheet: made here
  uint64_t* found = nullptr;                 // a bit for each sample
};
// Marks samples where the next one is on the other side, or the field comes closer, goes away at the next,
// and the tangents meet beyond the target.
void find_pairs(const PairArgs& args);

} // namespace bccsplat
