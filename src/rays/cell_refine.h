// SPDX-License-Identifier: Apache-2.0
// The loop that looks at marked cells again, each cut into 4^3 parts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kernel/kernel.h"
#include "rays/cell_bound.h"

namespace bccsplat {

// Sites in reach of a cell by kernels of at most 2 T: 3^3 of either coset, around one of its corners each.
inline constexpr size_t cell_sites = 54;
inline constexpr size_t refined_edge = refined_parts + 1;
inline constexpr size_t refined_corners = refined_edge * refined_edge * refined_edge;

// What each site weighs at the corners of the parts, x fastest. All cells are mirror images of the one whose
// even site is at (0, 0, 0) and whose odd one at (1, 1, 1).
struct RefinedStencil {
  static constexpr size_t room = 128; // whole vectors
  alignas(64) std::array<std::array<float, room>, cell_sites> weights{};
  static constexpr size_t few = 16; // corners that tell most cells
  alignas(64) std::array<std::array<float, few>, cell_sites> few_weights{};
  explicit RefinedStencil(const RadialKernel& kernel);
};

struct RefineArgs {
  const RefinedStencil* stencil = nullptr;
  float target = 0;
  float of_range = 0, of_middle = 0; // half of CellBound's, rounding of floats included
};

// The coefficients in reach of a cell: site (u, v, w) of coset c at ((c * 3 + w) * 3 + v) * 3 + u.
using CellSites = std::array<float, cell_sites>;

// Returns in which of at most 64 cells the field may be the target, a bit each; best target of this machine.
[[nodiscard]] uint64_t cells_that_may_hold(const RefineArgs& args, std::span<const CellSites> cells);

} // namespace bccsplat
