// SPDX-License-Identifier: Apache-2.0
#include "splat/points/touched_slots.h"

#include <bit>

namespace bccsplat {

std::vector<uint64_t> SlotSet::list() {
  std::vector<uint64_t> slots;
  for (size_t word = 0; word < bits_.size(); ++word) {
    before_[word] = static_cast<uint32_t>(slots.size());
    for (uint64_t rest = bits_[word]; rest != 0; rest &= rest - 1)
      slots.push_back(64 * word + std::countr_zero(rest));
  }
  return slots;
}

int64_t SlotSet::number(uint64_t slot) const {
  const uint64_t word = bits_[slot / 64], bit = uint64_t{1} << slot % 64;
  return word & bit ? int64_t{before_[slot / 64]} + std::popcount(word & (bit - 1)) : -1;
}

FoldedSites fold_sites(const Lattice3& lattice, int margin, const Int3& planes) {
  FoldedSites sites;
  for (size_t a = 0; a < 3; ++a)
    for (int n = 0; n < planes[a]; ++n) {
      const int h = n - margin, coset = lattice.bcc ? h & 1 : 0;
      sites[a].push_back(lattice.mirror(a, coset, lattice.bcc ? (h - coset) / 2 : h));
    }
  return sites;
}

SlotSet touched_slots(const Slice& slice, const FoldedSites& sites, const Int3& dims, int edge) {
  SlotSet touched(static_cast<uint64_t>(dims[0]) * dims[1] * dims[2]);
  const bool bcc = slice.lattice.bcc;
  for (int coset = 0; coset < (bcc ? 2 : 1); ++coset) {
    const BrickLayer& layer = slice.coset[coset];
    std::array<std::vector<std::vector<int>>, 3> reached; // by axis and brick of the slice, rising
    for (size_t a = 0; a < 3; ++a) {
      reached[a].resize(layer.brick_dims()[a]);
      for (size_t n = bcc ? static_cast<size_t>(coset) : 0; n < sites[a].size(); n += bcc ? 2 : 1) {
        std::vector<int>& into = reached[a][sites[a][n] / brick_edge];
        if (const int at = static_cast<int>(n) / edge; into.empty() || into.back() != at) into.push_back(at);
      }
    }
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      if (!layer.brick(slot)) continue;
      const Int3 at = layer.slot_position(slot);
      for (const int z : reached[2][at[2]])
        for (const int y : reached[1][at[1]])
          for (const int x : reached[0][at[0]])
            touched.add((static_cast<uint64_t>(z) * dims[1] + y) * dims[0] + x);
    }
  }
  return touched;
}

} // namespace bccsplat
