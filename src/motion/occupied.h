// SPDX-License-Identifier: Apache-2.0
// Where a slice is more than its base: by blocks of sites, so that air is told from it without a sum.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "field/slice.h"

namespace bccsplat::motion {

class Occupied {
 public:
  // Coefficients up to `nothing` are air. The field of a periodic lattice has none.
  Occupied(const Slice& slice, float nothing);

  // Whether a coefficient may be in reach of a place of the domain, lattice units.
  [[nodiscard]] bool at(const Vec3& p) const {
    return std::any_of(cosets_.begin(), cosets_.end(),
                       [&](const Blocks& b) { return b.any[b.index(block(b, p))]; });
  }
  // The same of some place between two, the ends of a box.
  [[nodiscard]] bool within(const Vec3& low, const Vec3& high) const;

 private:
  static constexpr int32_t edge = 4; // sites of a block, no fewer than a kernel reaches
  struct Blocks {
    Int3 dims{};
    double before = 0; // of the coset's first site, in blocks
    std::vector<uint8_t> any;
    [[nodiscard]] size_t index(const Int3& i) const {
      return static_cast<size_t>((i[2] * dims[1] + i[1]) * dims[0] + i[0]);
    }
  };
  [[nodiscard]] Int3 block(const Blocks& b, const Vec3& p) const {
    Int3 i;
    for (size_t a = 0; a < 3; ++a)
      i[a] = std::clamp(static_cast<int32_t>(p[a] * per_block_ + b.before), 0, b.dims[a] - 1);
    return i;
  }
  [[nodiscard]] static Blocks blocks_of(const BrickLayer& layer, float nothing);

  double per_block_ = 0; // blocks in a lattice unit
  std::vector<Blocks> cosets_;
};

} // namespace bccsplat::motion
