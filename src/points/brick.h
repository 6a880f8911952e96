// SPDX-License-Identifier: Apache-2.0
// Bricks: 16^3 sites of one coset of one layer, and the sparse layer made of them.
//
// A site is in one of three states. Kept: its occupancy bit is set and its value counts. Air: the bit is
// clear, the value is 0 (values are stored relative to air, or to the base of a field without air). Hole:
// missing data; the hole bit is set, the value is a smooth fill. Sites beyond the coset's dims in edge bricks
// are air.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "lattice/lattice.h"

namespace bccsplat {

inline constexpr int brick_edge = 16;
inline constexpr int brick_rows = brick_edge * brick_edge;
inline constexpr int brick_sites = brick_rows * brick_edge;

// One bit per site, one word per row along x; row = z*16 + y, bit = x.
using BrickMask = std::array<uint16_t, brick_rows>;

struct Brick {
  // (z*16 + y)*16 + x; value minus air, 0 where not kept. make_shared<Brick>() zeroes it,
  // make_shared_for_overwrite not.
  alignas(64) std::array<float, brick_sites> value;
  BrickMask kept{};
  std::unique_ptr<BrickMask> hole; // null: no holes

  [[nodiscard]] int count() const;
  [[nodiscard]] bool is_hole(int site) const { return hole && ((*hole)[site / 16] >> (site % 16) & 1); }
  // Sets `kept` where |value| > threshold and clears the other values; returns the number kept.
  int keep_above(float threshold);
};

// What is at the brick positions of one coset of one 3D lattice. A Slot converts to false where nothing is.
template<class Slot> class BrickSlots {
 public:
  BrickSlots() = default;
  BrickSlots(const Lattice3& lattice, int coset)
      : lattice_(lattice), coset_(coset), dims_(lattice.dims(coset)) {
    size_t slots = 1;
    for (size_t a = 0; a < 3; ++a) {
      brick_dims_[a] = (dims_[a] + brick_edge - 1) / brick_edge;
      slots *= brick_dims_[a];
    }
    bricks_.resize(slots);
    row_bricks_.resize(slots / row_slots());
  }

  [[nodiscard]] const Lattice3& lattice() const { return lattice_; }
  [[nodiscard]] int coset() const { return coset_; }
  [[nodiscard]] const Int3& dims() const { return dims_; }             // sites
  [[nodiscard]] const Int3& brick_dims() const { return brick_dims_; } // bricks, the last ones may be partial
  [[nodiscard]] size_t brick_slots() const { return bricks_.size(); }
  [[nodiscard]] size_t slot(int bx, int by, int bz) const {
    return (static_cast<size_t>(bz) * brick_dims_[1] + by) * brick_dims_[0] + bx;
  }
  [[nodiscard]] Int3 slot_position(size_t slot) const { // (bx, by, bz)
    const size_t nx = brick_dims_[0], ny = brick_dims_[1];
    return {static_cast<int32_t>(slot % nx), static_cast<int32_t>(slot / nx % ny),
            static_cast<int32_t>(slot / (nx * ny))};
  }

  [[nodiscard]] const Slot& share(size_t slot) const { return bricks_[slot]; }
  // Different slots may be set at once.
  void set(size_t slot, Slot brick) {
    const int change =
        static_cast<int>(static_cast<bool>(brick)) - static_cast<int>(static_cast<bool>(bricks_[slot]));
    if (change != 0)
      std::atomic_ref(row_bricks_[slot / row_slots()]).fetch_add(change, std::memory_order_relaxed);
    bricks_[slot] = std::move(brick);
  }

  // Rows of slots along x: row r holds slots r * row_slots() and on. Empty rows can be passed over.
  [[nodiscard]] size_t rows() const { return row_bricks_.size(); }
  [[nodiscard]] size_t row_slots() const { return brick_dims_[0]; }
  [[nodiscard]] bool row_empty(size_t row) const { return row_bricks_[row] == 0; }
  [[nodiscard]] uint64_t bricks() const { // that are there
    return std::accumulate(row_bricks_.begin(), row_bricks_.end(), int64_t{0});
  }

 protected:
  // Calls body(brick) for all that are there.
  template<class Body> void for_bricks(const Body& body) const {
    for (size_t r = 0; r < rows(); ++r)
      for (size_t s = r * row_slots(); !row_empty(r) && s < (r + 1) * row_slots(); ++s)
        if (bricks_[s]) body(bricks_[s]);
  }
  [[nodiscard]] uint64_t own_bytes() const { // of the slots themselves
    return bricks_.size() * sizeof(bricks_[0]) + row_bricks_.size() * sizeof(row_bricks_[0]);
  }

 private:
  Lattice3 lattice_;
  int coset_ = 0;
  Int3 dims_{}, brick_dims_{};
  std::vector<Slot> bricks_;
  std::vector<int32_t> row_bricks_; // how many, per row
};

// Bricks of one coset of one 3D lattice; absent bricks are air. Bricks are shared and immutable once in a
// layer.
class BrickLayer : public BrickSlots<std::shared_ptr<const Brick>> {
 public:
  using BrickSlots::BrickSlots;

  // Returns null where all sites are air.
  [[nodiscard]] const Brick* brick(size_t slot) const { return share(slot).get(); }
  [[nodiscard]] const Brick* brick(int bx, int by, int bz) const { return brick(slot(bx, by, bz)); }

  // Returns the value relative to air at site (x, y, z) inside dims.
  [[nodiscard]] float value(int x, int y, int z) const {
    const Brick* b = brick(x / brick_edge, y / brick_edge, z / brick_edge);
    return b ? b->value[(z % 16 * 16 + y % 16) * 16 + x % 16] : 0.0f;
  }

  [[nodiscard]] int64_t kept_sites() const;
  [[nodiscard]] uint64_t bytes() const; // memory held by the bricks
};

// Returns a layer as a dense array of dims() sites, x fastest.
[[nodiscard]] std::vector<float> layer_to_dense(const BrickLayer& layer);

} // namespace bccsplat
