// SPDX-License-Identifier: Apache-2.0
// The walk that coder and decoder share: through the coefficients of some layers, with what is known around
// each.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "formats/bcc4/wavelet/bands.h"

namespace bccsplat {

// Sums of magnitudes that were decoded before a coefficient.
struct Around {
  enum Sum : uint8_t {
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
    count
  };
};
inline constexpr int weight_unit = 64;
// The weight of each sum, in 1 / weight_unit; in the order of Around.
inline constexpr std::array<uint8_t, Around::count> around_weights{12, 4, 12, 8, 3, 4, 2, 8, 1, 4, 6, 1, 6};

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
};
// What is known of one coefficient.
struct WalkSite {
  uint32_t sum, sum_outside; // weighted: all, and without the row
  const uint16_t* here;      // magnitudes of the row; west is here[-1]
  const uint16_t *north, *up, *before, *parent_row;
};

class BandWalk {
 public:
  // room: for this walk alone until it ends.
  BandWalk(const Halvings& shape, int layers, WalkRoom& room)
      : shape_(shape), bands_(bands_of(shape)), layers_(layers) {
    size_t values = 0, flags = 0;
    for (const BandBox& box : bands_) {
      const BandMagnitudes& m = magnitudes_.emplace_back(box, layers);
      values += m.values(), flags += m.flags();
    }
    if (room.values.size() < values) room.values.resize(values);
    if (room.filled.size() < flags) room.filled.resize(flags);
    values = flags = 0;
    for (BandMagnitudes& m : magnitudes_) {
      m.place(room.values.data() + values, room.filled.data() + flags);
      values += m.values(), flags += m.flags();
    }
  }
  BandWalk(const BandWalk&) = delete;
  BandWalk& operator=(const BandWalk&) = delete;
  ~BandWalk() {
    for (BandMagnitudes& m : magnitudes_) m.clear();
  }

  // Calls visit.row(WalkRow, what is expected in all of it) -> bool: whether something is in it;
  // visit.site(WalkRow, x, WalkSite) -> magnitude.
  template<class Visit> void run(Visit& visit) {
    for (size_t b = 0; b < bands_.size(); ++b) {
      if (bands_[b].empty()) continue;
      find_relatives(static_cast<int>(b));
      outside_.assign(bands_[b].size[0], 0);
      outside_is_zero_ = true;
      for (int k = 0; k < layers_; ++k)
        for (int z = 0; z < bands_[b].size[2]; ++z) plane(static_cast<int>(b), k, z, visit);
    }
  }

 private:
  template<class Visit> void plane(int b, int k, int z, Visit& visit) {
    const BandBox& box = bands_[b];
    int y = 0;
    // Nine of ten planes are far from anything: nothing is expected in their rows until one has something.
    if (!near_something(magnitudes_[b], k, z)) {
      parent_row_ = nullptr;
      while (y < box.size[1] && !visit.row(WalkRow{box, b, k, z, y}, 0)) ++y;
      if (y == box.size[1]) return;
      sum_outside(magnitudes_[b], k, z, y, box.size[0]);
      sites(WalkRow{box, b, k, z, y++}, visit);
    }
    for (; y < box.size[1]; ++y) {
      const WalkRow row{box, b, k, z, y};
      sum_outside(magnitudes_[b], k, z, y, box.size[0]);
      if (visit.row(row, expected_in_row())) sites(row, visit);
    }
  }
  // Whether any row that sum_outside() adds may have anything.
  [[nodiscard]] bool near_something(const BandMagnitudes& m, int k, int z) const {
    if (m.filled(k, z - 1) | m.filled(k, z - 2) | m.filled(k - 1, z - 1) | m.filled(k - 1, z) |
        m.filled(k - 1, z + 1) | m.filled(k - 2, z))
      return true;
    const int pz = z >> shift_[2];
    if (parent_ && (parent_->filled(k, pz - 1) | parent_->filled(k, pz) | parent_->filled(k, pz + 1)))
      return true;
    return std::any_of(siblings_.begin(), siblings_.end(),
                       [&](int s) { return z < bands_[s].size[2] && magnitudes_[s].filled(k, z); });
  }

  void find_relatives(int b) {
    const BandBox& box = bands_[b];
    siblings_.clear();
    for (int i = 0; i < b; ++i)
      if (!bands_[i].empty() && bands_[i].direction != 0 && bands_[i].level == box.level)
        siblings_.push_back(i);
    parent_ = parent_of(box);
    for (int a = 0; a < 3; ++a) shift_[a] = shape_.halves(a, box.level + 1) ? 1 : 0;
  }
  BandMagnitudes* parent_of(const BandBox& box) {
    for (size_t i = 0; i < bands_.size(); ++i) {
      const BandBox& other = bands_[i];
      if (box.direction == 0 || other.empty() || other.direction == 0 || other.level != box.level + 1)
        continue;
      if (other.direction == box.direction || is_projection(other, box)) return &magnitudes_[i];
    }
    return nullptr;
  }
  // Where the coarser level does not halve all axes, the direction without those it does not halve.
  bool is_projection(const BandBox& coarse, const BandBox& fine) const {
    int halved = 0;
    for (int a = 0; a < 3; ++a) halved |= shape_.halves(a, fine.level + 1) ? 1 << a : 0;
    return (fine.direction & halved) != 0 && (fine.direction & halved) == coarse.direction;
  }

  // A row that has something.
  template<class Visit> void sites(const WalkRow& place, Visit& visit) {
    const auto& [box, b, k, z, y] = place;
    BandMagnitudes& m = magnitudes_[b];
    uint16_t* const here = m.row(k, z, y);
    m.fill(k, z, y);
    const uint16_t *north_row = m.row(k, z, y - 1), *up_row = m.row(k, z - 1, y),
                   *before_row = m.row(k - 1, z, y);
    const int sx = shift_[0];
    for (int x = 0; x < box.size[0]; ++x) {
      const uint32_t sum = outside_[x] + around_weights[Around::west] * here[x - 1] +
                           around_weights[Around::west2] * here[x - 2];
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

  // The weighted sums of what is known around a row, but for the row itself. Most rows are far from anything.
  void sum_outside(BandMagnitudes& m, int k, int z, int y, int n) {
    if (!outside_is_zero_) std::fill_n(outside_.data(), n, 0U);
    outside_is_zero_ = true;
    if (m.filled(k, z, y - 1) | m.filled(k, z, y - 2) | m.filled(k, z - 1, y) | m.filled(k, z - 1, y - 1) |
        m.filled(k, z - 1, y + 1) | m.filled(k, z - 2, y))
      add_layer(m, k, z, y, n);
    if (m.filled(k - 1, z, y) | m.filled(k - 1, z, y - 1) | m.filled(k - 1, z, y + 1) |
        m.filled(k - 1, z - 1, y) | m.filled(k - 1, z + 1, y) | m.filled(k - 2, z, y))
      add_layers_before(m, k, z, y, n);
    parent_row_ = nullptr;
    if (parent_) add_parent(k, z >> shift_[2], y >> shift_[1], n);
    for (const int s : siblings_) add_sibling(s, k, z, y, n);
  }
  [[nodiscard]] uint32_t expected_in_row() const {
    return outside_is_zero_ ? 0 : std::accumulate(outside_.begin(), outside_.end(), 0U);
  }
  void add_layer(BandMagnitudes& m, int k, int z, int y, int n) {
    const uint16_t *nn = m.row(k, z, y - 1), *n2 = m.row(k, z, y - 2), *u = m.row(k, z - 1, y),
                   *un = m.row(k, z - 1, y - 1), *us = m.row(k, z - 1, y + 1), *u2 = m.row(k, z - 2, y);
    constexpr auto& w = around_weights;
    outside_is_zero_ = false;
    for (int x = 0; x < n; ++x)
      outside_[x] += w[Around::north] * nn[x] + w[Around::up] * u[x] + w[Around::far] * (n2[x] + u2[x]) +
                     w[Around::diagonal] * (nn[x - 1] + nn[x + 1]) +
                     w[Around::diagonal_up] * (u[x - 1] + u[x + 1] + un[x] + us[x]);
  }
  void add_layers_before(BandMagnitudes& m, int k, int z, int y, int n) {
    const uint16_t *t = m.row(k - 1, z, y), *t2 = m.row(k - 2, z, y), *tn = m.row(k - 1, z, y - 1),
                   *ts = m.row(k - 1, z, y + 1), *tu = m.row(k - 1, z - 1, y), *td = m.row(k - 1, z + 1, y);
    constexpr auto& w = around_weights;
    outside_is_zero_ = false;
    for (int x = 0; x < n; ++x)
      outside_[x] += w[Around::before] * t[x] + w[Around::before2] * t2[x] +
                     w[Around::around_before] * (t[x - 1] + t[x + 1] + tn[x] + ts[x] + tu[x] + td[x]);
  }
  // z, y: of the parent.
  void add_parent(int k, int z, int y, int n) {
    BandMagnitudes& m = *parent_;
    const uint16_t* const p = m.row(k, z, y);
    parent_row_ = p;
    if (!(m.filled(k, z, y) | m.filled(k, z, y - 1) | m.filled(k, z, y + 1) | m.filled(k, z - 1, y) |
          m.filled(k, z + 1, y)))
      return;
    const uint16_t *pn = m.row(k, z, y - 1), *ps = m.row(k, z, y + 1), *pu = m.row(k, z - 1, y),
                   *pd = m.row(k, z + 1, y);
    constexpr auto& w = around_weights;
    outside_is_zero_ = false;
    for (int x = 0; x < n; ++x) {
      const int i = x >> shift_[0];
      outside_[x] += w[Around::parent] * p[i] +
                     w[Around::around_parent] * (p[i - 1] + p[i + 1] + pn[i] + ps[i] + pu[i] + pd[i]);
    }
  }
  void add_sibling(int s, int k, int z, int y, int n) {
    const BandBox& box = bands_[s];
    if (y >= box.size[1] || z >= box.size[2] || !magnitudes_[s].filled(k, z, y)) return;
    const uint16_t* const row = magnitudes_[s].row(k, z, y);
    const int count = std::min(n, box.size[0]);
    outside_is_zero_ = false;
    for (int x = 0; x < count; ++x) outside_[x] += around_weights[Around::siblings] * row[x];
  }

  const Halvings shape_;
  std::vector<BandBox> bands_;
  int layers_;
  std::vector<BandMagnitudes> magnitudes_;
  std::vector<uint32_t> outside_;
  bool outside_is_zero_ = true;
  BandMagnitudes* parent_ = nullptr;
  const uint16_t* parent_row_ = nullptr;
  std::array<int, 3> shift_{};
  std::vector<int> siblings_;
};

} // namespace bccsplat
