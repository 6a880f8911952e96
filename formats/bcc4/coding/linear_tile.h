// SPDX-License-Identifier: Apache-2.0
// A decoded tile whose samples are linear in its coefficients, neither rounded to codes nor held within a
// range: any sum of its layers is made by one inverse (bcc4.md, section 12).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/wavelet/layer_sums.h"
#include "formats/bcc4/wavelet/tile_coefficients.h"

namespace bccsplat {

// Which sites of a brick of a tile are kept, or holes, in its layers.
class TileMasks {
 public:
  TileMasks() = default;
  // One for each layer, or none: no site in any layer.
  explicit TileMasks(std::vector<BrickMask> layers);
  [[nodiscard]] const BrickMask& of(int layer) const;
  [[nodiscard]] bool alike() const { return masks_.size() < 2; } // in all layers
  [[nodiscard]] bool empty() const { return masks_.empty(); }
  [[nodiscard]] uint64_t bytes() const { return masks_.capacity() * sizeof(BrickMask); }
  bool operator==(const TileMasks&) const = default;

 private:
  std::vector<BrickMask> masks_; // one where all are alike
};

class LinearTile {
 public:
  // Decodes the stored bytes of a tile of a Cartesian lattice, padding included. Throws where they are
  // damaged.
  LinearTile(const TilePlace& place, const ChunkCodes& codes, const Bcc4Chunk& entry,
             std::span<const std::byte> bytes, ChunkScratch& scratch);
  // What these sites become.
  LinearTile(const TileSites& sites, TileCoefficients coefficients);
  // A tile whose sites are all holes.
  explicit LinearTile(const TilePlace& place);

  [[nodiscard]] int edge() const { return edge_; }
  [[nodiscard]] int bricks() const { return edge_ * edge_ * edge_; }
  [[nodiscard]] int layers() const { return layers_; }
  [[nodiscard]] const BrickMask& kept(int brick, int layer) const { return kept_[brick].of(layer); }
  [[nodiscard]] bool keeps_any(int brick) const { return !kept_[brick].empty(); }
  [[nodiscard]] const BrickMask& hole(int brick, int layer) const { return hole_[brick].of(layer); }
  // Returns whether all layers keep the same sites.
  [[nodiscard]] bool keeps_alike() const;
  // Returns whether the other one has the same box, halved as often, and keeps the same sites.
  [[nodiscard]] bool adds_to(const LinearTile& other) const;
  // Where the rows of a brick are in the box.
  [[nodiscard]] BrickRows rows(int brick) const;
  [[nodiscard]] const TileCoefficients& coefficients() const { return coefficients_; }
  // Makes a layer: its samples in codes, less that of air.
  void make_layer(int layer, std::vector<float>& box) const;
  // The smallest and the largest code that is nearest to a kept sample; of those that there are.
  [[nodiscard]] CodeRange range(const ChunkCodes& codes) const;
  [[nodiscard]] uint64_t bytes() const;

 private:
  template<class Bricks> void take_masks(const Bricks& bricks);

  int edge_, layers_;
  std::vector<TileMasks> kept_, hole_; // by brick, x fastest
  TileCoefficients coefficients_;
};

// The smallest and the largest of samples that are told in codes, less that of air.
struct LinearRange {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  void add(float sample) { low = std::min(low, sample), high = std::max(high, sample); }
  // The codes nearest to them, of those that there are.
  [[nodiscard]] CodeRange nearest(const ChunkCodes& codes) const;
};
// Calls body(site of the brick, sample) for the kept sites of a layer of a brick. box: that layer.
template<class Body>
void for_kept(const LinearTile& tile, int brick, int layer, std::span<const float> box, const Body& body) {
  const BrickMask& kept = tile.kept(brick, layer);
  const BrickRows rows = tile.rows(brick);
  for (size_t r = 0; r < brick_rows; ++r) {
    if (kept[r] == 0) continue;
    const float* const from =
        box.data() + rows.first + r / brick_edge * rows.plane + r % brick_edge * rows.row;
    for (unsigned bits = kept[r]; bits; bits &= bits - 1) {
      const size_t x = std::countr_zero(bits);
      body(r * brick_edge + x, from[x]);
    }
  }
}

} // namespace bccsplat
