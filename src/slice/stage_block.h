// What a prefilter stage needs of the bricks around one brick: where every row lies, mirrors resolved.
#pragma once

#include <array>
#include <memory>

#include "points/brick.h"
#include "slice/prefilter.h"

namespace bccsplat {

// A layer that a stage adds: `centre` times its value and `neighbours` times the sum of the 6 values around.
// Pointers to the values of bricks; those that are not there are zeros.
struct StageTerm {
  float centre, neighbours;
  const float* own;
  std::array<const float*, 3> low, high; // the bricks of the sites before and after this one's, per axis
};

// The layers of the other coset, whose 8 sites around each site are summed. Of site i of the brick these are
// sites i + shift and i + shift + 1 per axis, shift -1 or 0.
struct StageCross {
  struct Axis {
    // Of site i + shift: which of two bricks, and its place there.
    std::array<uint8_t, brick_edge + 1> half, site;
  };
  // A site along x that stands in the other brick, or is a mirror image: it replaces what the row holds.
  struct Patch {
    int index, half, site; // i of site i + shift
  };
  float weight = 0;
  int layers = 0; // none: nothing is summed
  int shift = 0;
  Axis y, z;
  int patches = 0;
  std::array<Patch, 3> patch{};
  std::array<std::array<const float*, 8>, 2> brick{}; // per layer: 4 * (z half) + 2 * (y half) + (x half)
};

struct StageBlock {
  Int3 width{};                 // sites of the brick inside the lattice
  Int3 low_site{}, high_site{}; // places in the bricks StageTerm::low and high, of sites -1 and `width`
  int terms = 0;
  int neighbour_terms = 0; // terms whose neighbours count come first
  std::array<StageTerm, 6> term{};
  StageCross cross;

  [[nodiscard]] bool empty() const { return terms == 0 && cross.layers == 0; }
};

[[nodiscard]] StageBlock stage_block(const PrefilterStage& stage, const StageInput& input, const Int3& brick);

} // namespace bccsplat
