// SPDX-License-Identifier: Apache-2.0
// The walk that coder and decoder share: through the coefficients of a chunk, with what is known around each.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/bench/coder/bands.h"

namespace bccsplat::bench {

// Sums of magnitudes that were decoded before a coefficient.
enum Around : uint8_t {
  west,
  west2,
  north,
  up,
  far,
  diagonal,
  diagonal_up,
  before,
  around_before,
  before2,
  parent,
  around_parent,
  siblings,
  around_count
};
inline constexpr int weight_unit = 64;
using AroundWeights = std::array<uint8_t, around_count>; // of the sums, in 1 / weight_unit
inline constexpr int most_levels = 6;
using LevelWeights = std::array<AroundWeights, most_levels + 1>; // by level; 0: the coarse rest

// An expected magnitude, in steps of a quarter of an octave.
inline constexpr int bucket_count = 64;
inline int bucket_of(uint32_t sum) {
  if (sum < 4) return static_cast<int>(sum);
  const int octave = std::bit_width(sum) - 3;
  const int bucket = octave * 4 + static_cast<int>(sum >> octave);
  return bucket < bucket_count ? bucket : bucket_count - 1;
}

// One row of a band in one layer.
struct WalkRow {
  const BandBox& box;
  int band, k, z, y;
  bool coarse;
};
// What is known of one coefficient.
struct WalkSite {
  uint32_t sum, sum_outside; // weighted: all, and without the row
  const uint16_t* here;      // magnitudes of the row; west is here[-1]
  const uint16_t *north, *up, *before, *parent_row;
};

class ChunkWalk {
 public:
  // `coarse`: the walk through what all chunks need, done; null in that walk itself. Both outlive this.
  ChunkWalk(const Chain& chain, std::vector<BandBox> bands, int layers, const LevelWeights& weights,
            ChunkWalk* coarse)
      : chain_(chain), bands_(std::move(bands)), layers_(layers), weights_(weights), coarse_(coarse),
        magnitudes_(bands_.size()) {}

  // Calls visit.row(WalkRow, sums, width) -> bool: whether something is in it; visit.site(WalkRow, x,
  // WalkSite) -> magnitude.
  template<class Visit> void run(Visit& visit) {
    for (size_t b = 0; b < bands_.size(); ++b) {
      magnitudes_[b] = BandMagnitudes(bands_[b], layers_);
      if (bands_[b].empty()) continue;
      find_relatives(static_cast<int>(b));
      sums_.assign(around_count, std::vector<uint32_t>(bands_[b].size[0]));
      outside_.resize(bands_[b].size[0]);
      for (int k = 0; k < layers_; ++k)
        for (int z = 0; z < bands_[b].size[2]; ++z)
          for (int y = 0; y < bands_[b].size[1]; ++y) row(static_cast<int>(b), k, z, y, visit);
    }
  }
  [[nodiscard]] const std::vector<std::vector<uint32_t>>& sums() const { return sums_; }

 private:
  void find_relatives(int b) {
    const BandBox& box = bands_[b];
    siblings_.clear();
    for (int i = 0; i < b; ++i)
      if (!bands_[i].empty() && bands_[i].direction != 0 && bands_[i].level == box.level)
        siblings_.push_back(i);
    parent_ = parent_in(*this, box);
    offset_ = {};
    if (!parent_ && coarse_) find_parent_outside(box);
    weight_ = weights_[box.direction == 0 ? 0 : box.level];
    for (int a = 0; a < 3; ++a) shift_[a] = chain_.halves(a, box.level + 1) ? 1 : 0;
  }
  BandMagnitudes* parent_in(ChunkWalk& walk, const BandBox& box) {
    for (size_t i = 0; i < walk.bands_.size(); ++i) {
      const BandBox& other = walk.bands_[i];
      if (box.direction == 0 || other.empty() || other.direction == 0 || other.level != box.level + 1)
        continue;
      if (other.direction == box.direction || is_projection(other, box)) return &walk.magnitudes_[i];
    }
    return nullptr;
  }
  void find_parent_outside(const BandBox& box) {
    parent_ = parent_in(*coarse_, box);
    for (int a = 0; a < 3; ++a) {
      const int band = box.direction >> a & 1 ? chain_.kept(a, box.level) : 0;
      offset_[a] = (box.begin[a] - band) >> (chain_.halves(a, box.level + 1) ? 1 : 0);
    }
  }
  // Where the coarser level does not halve all axes, the direction without those it does not halve.
  bool is_projection(const BandBox& coarse, const BandBox& fine) const {
    int halved = 0;
    for (int a = 0; a < 3; ++a) halved |= chain_.halves(a, fine.level + 1) ? 1 << a : 0;
    return (fine.direction & halved) != 0 && (fine.direction & halved) == coarse.direction;
  }

  template<class Visit> void row(int b, int k, int z, int y, Visit& visit) {
    const BandBox& box = bands_[b];
    BandMagnitudes& m = magnitudes_[b];
    uint16_t* const here = m.row(k, z, y);
    add_around(m, k, z, y, box.size[0]);
    parent_row_ = nullptr;
    if (parent_) add_parent(k, z, y, box.size[0]);
    add_siblings(k, z, y, box.size[0]);
    weigh(box.size[0]);
    const WalkRow place{box, b, k, z, y, box.direction == 0};
    if (!visit.row(place, outside_)) return;
    const uint16_t *north_row = m.row(k, z, y - 1), *up_row = m.row(k, z - 1, y),
                   *before_row = m.row(k - 1, z, y);
    const int sx = shift_[0];
    for (int x = 0; x < box.size[0]; ++x) {
      sums_[west][x] = here[x - 1];
      sums_[west2][x] = here[x - 2];
      const uint32_t sum = outside_[x] + weight_[west] * here[x - 1] + weight_[west2] * here[x - 2];
      const WalkSite site{sum,
                          outside_[x],
                          here + x,
                          north_row + x,
                          up_row + x,
                          before_row + x,
                          parent_row_ ? parent_row_ + (x >> sx) : nullptr};
      here[x] = visit.site(place, x, site);
    }
  }

  void add_around(BandMagnitudes& m, int k, int z, int y, int n) {
    const uint16_t *nn = m.row(k, z, y - 1), *n2 = m.row(k, z, y - 2), *u = m.row(k, z - 1, y),
                   *un = m.row(k, z - 1, y - 1), *us = m.row(k, z - 1, y + 1), *u2 = m.row(k, z - 2, y);
    const uint16_t *t = m.row(k - 1, z, y), *t2 = m.row(k - 2, z, y), *tn = m.row(k - 1, z, y - 1),
                   *ts = m.row(k - 1, z, y + 1), *tu = m.row(k - 1, z - 1, y), *td = m.row(k - 1, z + 1, y);
    for (int x = 0; x < n; ++x) {
      sums_[north][x] = nn[x];
      sums_[up][x] = u[x];
      sums_[far][x] = n2[x] + u2[x];
      sums_[diagonal][x] = nn[x - 1] + nn[x + 1];
      sums_[diagonal_up][x] = u[x - 1] + u[x + 1] + un[x] + us[x];
      sums_[before][x] = t[x];
      sums_[around_before][x] = t[x - 1] + t[x + 1] + tn[x] + ts[x] + tu[x] + td[x];
      sums_[before2][x] = t2[x];
    }
  }
  void add_parent(int k, int z, int y, int n) {
    BandMagnitudes& m = *parent_;
    const int sx = shift_[0], x0 = offset_[0];
    z = (z >> shift_[2]) + offset_[2], y = (y >> shift_[1]) + offset_[1];
    const uint16_t *p = m.row(k, z, y) + x0, *pn = m.row(k, z, y - 1) + x0, *ps = m.row(k, z, y + 1) + x0,
                   *pu = m.row(k, z - 1, y) + x0, *pd = m.row(k, z + 1, y) + x0;
    parent_row_ = p;
    for (int x = 0; x < n; ++x) {
      const int i = x >> sx;
      sums_[parent][x] = p[i];
      sums_[around_parent][x] = p[i - 1] + p[i + 1] + pn[i] + ps[i] + pu[i] + pd[i];
    }
  }
  void add_siblings(int k, int z, int y, int n) {
    auto& sum = sums_[siblings];
    for (int x = 0; x < n; ++x) sum[x] = 0;
    for (const int s : siblings_) {
      const BandBox& box = bands_[s];
      if (y >= box.size[1] || z >= box.size[2]) continue;
      const uint16_t* const row = magnitudes_[s].row(k, z, y);
      const int count = n < box.size[0] ? n : box.size[0];
      for (int x = 0; x < count; ++x) sum[x] += row[x];
    }
  }
  void weigh(int n) {
    for (int x = 0; x < n; ++x) outside_[x] = 0;
    for (int a = north; a < around_count; ++a) {
      if (!parent_ && (a == parent || a == around_parent)) continue;
      const uint32_t w = weight_[a];
      if (w == 0) continue;
      const uint32_t* const sum = sums_[a].data();
      for (int x = 0; x < n; ++x) outside_[x] += w * sum[x];
    }
  }

  const Chain& chain_;
  std::vector<BandBox> bands_;
  int layers_;
  const LevelWeights& weights_;
  ChunkWalk* coarse_;
  std::vector<BandMagnitudes> magnitudes_;
  std::vector<std::vector<uint32_t>> sums_;
  std::vector<uint32_t> outside_;
  AroundWeights weight_{};
  BandMagnitudes* parent_ = nullptr;
  std::array<int, 3> offset_{}; // of the chunk in a parent that all share
  const uint16_t* parent_row_ = nullptr;
  std::array<int, 3> shift_{};
  std::vector<int> siblings_;
};

// Calls body(walk) for the coarse part of a slab and then for each of its chunks, x fastest; it has to run
// each.
template<class Body>
void walk_slab(const Chain& chain, int edge, int layers, const LevelWeights& weights, const Body& body) {
  ChunkWalk coarse(chain, coarse_bands(chain), layers, weights, nullptr);
  body(coarse);
  const std::array<int, 3> n = chunk_counts(chain, edge);
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        ChunkWalk chunk(chain, chunk_bands(chain, {x, y, z}, edge), layers, weights, &coarse);
        body(chunk);
      }
}

} // namespace bccsplat::bench
