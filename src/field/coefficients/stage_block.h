// Tells a prefilter stage where every row of the bricks around one brick lies, mirrors resolved.
#pragma once

#include <array>
#include <memory>

#include "field/coefficients/prefilter.h"
#include "points/brick.h"

namespace bccsplat {

// A layer that a stage adds: `centre` times its value and `neighbours` times the sum of the 6 values around.
// Pointers to the values of bricks; those that are not there are zeros.
struct StageTerm {
  float centre, neighbours;
  const float* own;
  std::array<const float*, 3> low, high; // the bricks of the sites before and after this one's, per axis
};

// The layers whose 8 sites around each site are summed: of site i of the brick these are sites i + shift and
// i + shift + span per axis. BCC and D4*: the other coset, shift -1 or 0, span 1. CC: the corners (+-1, +-1,
// +-1) of the layer itself, shift -1, span 2.
struct StageCross {
  struct Axis {
    // In which of three bricks site i + shift lies (0: the one with the brick's own number), and where there.
    std::array<uint8_t, brick_edge + 2> third, site;
  };
  // A site along x that lies in another brick, or is a mirror image: it replaces what the row holds.
  struct Patch {
    int index, third, site; // i of site i + shift
  };
  using Bricks = std::array<std::array<std::array<const float*, 3>, 3>, 3>; // by third along z, y, x
  float weight = 0;
  int layers = 0; // none: nothing is summed
  int shift = 0, span = 1;
  Axis y, z;
  int patches = 0;
  std::array<Patch, 4> patch{};
  std::array<Bricks, 2> brick{}; // per layer
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
