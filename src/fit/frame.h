// One frame of a Cartesian series as its owner holds it: dense boxes of any numeric type, air between them.
#pragma once

#include <array>
#include <cstdint>

#include "formats/bcc4_info.h"

namespace bccsplat {

// A dense box of one frame; what no box covers is air. Boxes of a frame do not overlap.
struct FrameBox {
  const void* data = nullptr;             // the sample at `begin`; borrowed
  SourceType type = SourceType::f32;      // not unknown
  std::array<int64_t, 3> begin{0, 0, 0};  // source index (x, y, z)
  std::array<int64_t, 3> dims{0, 0, 0};   // samples; begin + dims within the frame
  std::array<int64_t, 3> stride{0, 0, 0}; // bytes between neighbours; all 0: packed, x fastest
};

// What a NaN or infinity of the source does. Numbers of the C ABI.
enum class NonFinite : uint8_t {
  error = 1, // Code::nonfinite_value, with frame and voxel in the text
  hole = 2,  // missing data: filled smoothly, marked as a hole on the lattice
  clamp = 3  // NaN: air; infinities: the end of the channel's range
};

} // namespace bccsplat
