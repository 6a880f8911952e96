// SPDX-License-Identifier: Apache-2.0
// Corrections at source samples, by which a stated error bound holds where the lattice alone misses it
// (bcc4.md, section 10).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/paged_vector.h"

namespace bccsplat {

// A source sample of one frame, voxel = (z * Ny + y) * Nx + x, and a number of steps.
struct ResidualSample {
  uint64_t voxel = 0;
  int64_t steps = 0;
  bool operator==(const ResidualSample&) const = default;
};

// A frame may have one at every sample.
using ResidualList = PagedVector<ResidualSample>;

// The corrections of one channel at one frame; both lists have rising voxels.
struct FrameResiduals {
  ResidualList add; // steps to add to the reconstructed value
  ResidualList set; // data where the lattice has a hole: the value is air plus the steps
  [[nodiscard]] bool empty() const { return add.empty() && set.empty(); }
  bool operator==(const FrameResiduals&) const = default;
};

// A list of steps alone, as bricks have it: voxels are local to the brick.
[[nodiscard]] std::vector<std::byte> write_corrections(std::span<const ResidualSample> list);
// `voxels` is their number in a brick. Throws as below.
[[nodiscard]] ResidualList read_corrections(std::span<const std::byte> decoded, uint64_t voxels,
                                            uint64_t offset);

[[nodiscard]] std::vector<std::byte> write_residuals(const FrameResiduals& residuals);
// `voxels` is their number in a frame; `offset` of the block is for error texts. Throws corrupt, truncated.
[[nodiscard]] FrameResiduals read_residuals(std::span<const std::byte> decoded, uint64_t voxels,
                                            uint64_t offset);

} // namespace bccsplat
