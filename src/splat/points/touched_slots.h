// SPDX-License-Identifier: Apache-2.0
// Which bricks of the splatter a slice's bricks reach, mirror images included; nothing is spent on the
// others.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "field/slice.h"

namespace bccsplat {

// A few out of many slots, and their numbers in rising order.
class SlotSet {
 public:
  explicit SlotSet(uint64_t slots) : bits_(slots / 64 + 1), before_(bits_.size()) {}
  void add(uint64_t slot) { bits_[slot / 64] |= uint64_t{1} << slot % 64; }
  // Returns all of them in rising order, and numbers them: number() is right from here on.
  [[nodiscard]] std::vector<uint64_t> list();
  // Returns -1 for a slot that is not among them.
  [[nodiscard]] int64_t number(uint64_t slot) const;

 private:
  std::vector<uint64_t> bits_;
  std::vector<uint32_t> before_; // how many are in earlier words
};

// Per axis and plane, counted from the first one of the margin: the site of its coset that is stored,
// mirrored into the domain.
using FoldedSites = std::array<std::vector<int32_t>, 3>;
[[nodiscard]] FoldedSites fold_sites(const Lattice3& lattice, int margin, const Int3& planes);

// dims counts the bricks of the splatter, of `edge` planes each.
[[nodiscard]] SlotSet touched_slots(const Slice& slice, const FoldedSites& sites, const Int3& dims, int edge);

} // namespace bccsplat
