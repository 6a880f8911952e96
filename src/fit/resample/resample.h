// SPDX-License-Identifier: Apache-2.0
// Spatial resampling: one frame -> its values at the sites of both cosets.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "base/context.h"
#include "fit/axis/filter.h"
#include "fit/axis/near_source.h"
#include "fit/axis/resample_tile.h"
#include "fit/beyond/face_noise.h"
#include "fit/frame/frame.h"
#include "fit/frame/scan.h"
#include "fit/kept/packed_block.h"
#include "fit/kept/site_block.h"
#include "lattice/lattice.h"
#include "points/sample_source.h"

namespace bccsplat {

class SpatialResampler {
 public:
  // faces: how samples beyond the faces are predicted, where planes lie outside.
  SpatialResampler(const Lattice4& lattice, const FaceLevels& faces = usual_face_levels);

  // Returns null for a brick where all samples within its reach are air. The result has the same bits for any
  // number of threads and however the frame is divided into boxes. unit: as of packing_unit.
  // bricks: those that are made, by whole_tiles; the others are null.
  [[nodiscard]] FrameSites resample(const Frame& frame, const CellRanges& cells, float unit,
                                    SiteBlockPool& pool, const Context& context,
                                    const BrickBox& bricks = {}) const;

  // Returns the bricks that are made together with those of a box: what is made of a brick depends on all
  // samples that these see.
  [[nodiscard]] BrickBox whole_tiles(BrickBox bricks) const;
  // Returns the samples that these bricks see; empty where there are none. Not along periodic axes.
  [[nodiscard]] Region seen_by(const BrickBox& bricks) const;

 private:
  // One axis of one coset.
  struct Axis {
    FilterTable table;
    // For each brick, half-open: the source samples its sites depend on, mirrored ones beyond the ends
    // included, and those of the frame that this takes. Along a periodic axis the two are the same: samples
    // are counted on beyond its ends.
    std::vector<std::array<int64_t, 2>> extended, inside;
    std::vector<int64_t> nearest;             // sample of each site
    std::vector<std::array<int64_t, 2>> near; // the first and the last of the samples around it
  };
  // One brick along x: sixteen sites at a time.
  struct BrickX {
    int64_t base = 0;
    std::array<int32_t, 16> index{};
    std::vector<float> weight; // k * 16 + site
    int64_t nearest_base = 0;
    std::array<int32_t, 16> nearest_index{};
  };
  struct Coset {
    Int3 dims{};
    std::array<Axis, 3> axis;
    std::vector<BrickX> x;
  };
  struct Tile;
  struct Scratch;

  [[nodiscard]] static Int3 brick_dims(const Coset& coset) {
    Int3 n;
    for (size_t a = 0; a < 3; ++a) n[a] = (coset.dims[a] + brick_edge - 1) / brick_edge;
    return n;
  }
  [[nodiscard]] static size_t slot(const Coset& coset, const Int3& brick) {
    const Int3 n = brick_dims(coset);
    return (static_cast<size_t>(brick[2]) * n[1] + brick[1]) * n[0] + brick[0];
  }
  // Returns the bricks of a box that there are.
  [[nodiscard]] BrickBox inside(BrickBox bricks) const;
  [[nodiscard]] static size_t slots(const Coset& coset) {
    const Int3 n = brick_dims(coset);
    return slot(coset, {0, 0, n[2]});
  }
  [[nodiscard]] Region brick_region(const Coset& coset, const Int3& brick) const;
  [[nodiscard]] TileTaps tile_taps(size_t axis, const Coset& coset, int32_t brick, int64_t first_row,
                                   std::vector<int32_t>& rows) const;
  void mark_source(const float* rows, size_t pitch, int64_t y, const Tile& tile, size_t coset) const;
  void mark_near(TileBits& bits, const Tile& tile, size_t coset) const;
  [[nodiscard]] Tile find_tile(const Int3& brick, const CellRanges& cells, SiteBlockPool& pool) const;
  // Hands the blocks of a tile to the frame.
  void keep_tile(Tile tile, float unit, SiteBlockPool& pool, FrameSites& sites) const;
  void resample_tile(const Frame& frame, const Tile& tile, Scratch& scratch, const Context& context) const;

  std::array<int64_t, 3> n_{}; // source samples
  AxisFlags turning_{};        // axes whose first sample follows the last one
  int cosets_ = 1;
  int tile_bricks_ = 4; // along x
  std::array<Coset, 2> coset_;
};

} // namespace bccsplat
